"""The names of error codes, and of classes of codes, that `ext:on_error` may use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from flexbe_synthesizer.core.chart.error_routes import LARGEST_CODE, is_error_name

ABOVE_BEHAVIOR = "above_behavior"  # the codes that a task or use case supervisor handles first
RECOVERABLE, SERIOUS = "recoverable", "serious"  # the codes of that severity
CLASSES = (ABOVE_BEHAVIOR, RECOVERABLE, SERIOUS)
_LEVELS_ABOVE = ("task", "use_case")


class ListedCode(NamedTuple):
    """A row of a table of error codes.

    Attributes:
        name: of the code.
        code: its number, from 0 (no error).
        severity: of its fault, "recoverable" or "serious"; None of a code that reports no fault.
        first_level: who handles it first, "action", "behavior", "task" or "use_case"; None as well.
    """

    name: str
    code: int
    severity: str | None = None
    first_level: str | None = None


def error_names(listed: Iterable[ListedCode]) -> Mapping[str, tuple[int, ...]]:
    """Return the codes, ascending, of each class and of each name, classes first.

    The code 0 is no error and has no name. Of two codes of one name the first counts.
    """
    classes: dict[str, set[int]] = {name: set() for name in CLASSES}
    names: dict[str, tuple[int, ...]] = {}
    for row in listed:
        if row.code == 0:
            continue
        names.setdefault(row.name, (row.code,))
        if row.first_level in _LEVELS_ABOVE:
            classes[ABOVE_BEHAVIOR].add(row.code)
        if row.severity in (RECOVERABLE, SERIOUS):
            classes[row.severity].add(row.code)
    found = {name: tuple(sorted(codes)) for name, codes in classes.items() if codes}
    return {**found, **{name: code for name, code in names.items() if name not in CLASSES}}


def read_error_table(table: object) -> tuple[ListedCode, ...]:
    """Return the codes of a table of faults, or of a table of abilities, which may list some.

    Args:
        table: parsed; its sections `no_fault` and `faults`, both optional, have the form of
            remodel_msgs/config/faults.schema.json. Only what names need is read and checked.

    Raises:
        ValueError: if it is no such table.
    """
    if not isinstance(table, Mapping):
        raise ValueError("a table of error codes is a mapping with a list of 'faults'")
    found = [ListedCode(*_checked(row)) for row in _section(table, "no_fault")]
    for fault in _section(table, "faults"):
        if not isinstance(fault, Mapping):
            raise ValueError(f"{fault!r} is no fault with 'codes'")
        for row in fault.get("codes") or ():
            found.append(
                ListedCode(*_checked(row), fault.get("severity"), fault.get("first_level"))
            )
    return tuple(found)


def _section(table: Mapping[str, object], name: str) -> Iterable[object]:
    """Return the rows of a section of a table; none if it is missing."""
    rows = table.get(name, [])
    if not isinstance(rows, list):
        raise ValueError(f"'{name}' is {rows!r}; allowed: a list")
    return rows


def _checked(row: object) -> tuple[str, int]:
    """Return name and code of a row."""
    name = row.get("name") if isinstance(row, Mapping) else None
    if not isinstance(row, Mapping) or not isinstance(name, str) or not is_error_name(name):
        raise ValueError(f"{row!r} has no 'name' of letters, digits and '_' after a letter")
    code = row.get("code")
    if not isinstance(code, int) or not 0 <= code <= LARGEST_CODE:
        raise ValueError(f"'code' of {name} is {code!r}; allowed: 0 to {LARGEST_CODE}")
    return name, code
