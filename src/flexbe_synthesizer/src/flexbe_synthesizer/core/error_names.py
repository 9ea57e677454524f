"""The names of error codes, and of classes of codes, that `ext:on_error` may use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from flexbe_synthesizer.core.error_routes import LARGEST_CODE, is_error_name

ABOVE_BEHAVIOR = "above_behavior"  # the codes that a task or use case supervisor handles first
RECOVERABLE, SERIOUS = "recoverable", "serious"  # the codes of that severity
CLASSES = (ABOVE_BEHAVIOR, RECOVERABLE, SERIOUS)
_LEVELS_ABOVE = ("task", "use_case")


def read_error_names(table: object) -> Mapping[str, tuple[int, ...]]:
    """Return the codes of each name and of each class of a table of error codes.

    Args:
        table: rows with `name` and `code`, and if they say so `severity` ("recoverable" or
            "serious") and `first_level` (who handles it first: "action", "behavior", "task" or
            "use_case"). The code 0 is no error and gets no name.

    Raises:
        ValueError: if it is no such table.
    """
    if not isinstance(table, Sequence) or isinstance(table, str):
        raise ValueError("a table of error codes is a list of rows with 'name' and 'code'")
    found: dict[str, tuple[int, ...]] = {}
    for row in table:
        name, code = _checked(row)
        if name in found or name in CLASSES:
            raise ValueError(f"the name {name!r} stands twice, or is that of a class")
        if code > 0:
            found[name] = (code,)
    return merged((found, _classes(table)))


def _checked(row: object) -> tuple[str, int]:
    """Return name and code of a row."""
    name = row.get("name") if isinstance(row, Mapping) else None
    if not isinstance(row, Mapping) or not isinstance(name, str) or not is_error_name(name):
        raise ValueError(f"{row!r} has no 'name' of letters, digits and '_' after a letter")
    code = row.get("code")
    if not isinstance(code, int) or not 0 <= code <= LARGEST_CODE:
        raise ValueError(f"'code' of {name} is {code!r}; allowed: 0 to {LARGEST_CODE}")
    return name, code


def _classes(table: Iterable[Mapping[str, object]]) -> Mapping[str, tuple[int, ...]]:
    found: dict[str, list[int]] = {name: [] for name in CLASSES}
    for row in table:
        code = row["code"]
        if not isinstance(code, int) or code == 0:
            continue
        if row.get("first_level") in _LEVELS_ABOVE:
            found[ABOVE_BEHAVIOR].append(code)
        if row.get("severity") in (RECOVERABLE, SERIOUS):
            found[str(row["severity"])].append(code)
    return {name: tuple(codes) for name, codes in found.items() if codes}


def merged(tables: Iterable[Mapping[str, tuple[int, ...]]]) -> Mapping[str, tuple[int, ...]]:
    """Return several tables as one: a class has the codes of all, a code those of the first."""
    found: dict[str, tuple[int, ...]] = {}
    for table in tables:
        for name, codes in table.items():
            if name in CLASSES:
                found[name] = tuple(sorted({*found.get(name, ()), *codes}))
            else:
                found.setdefault(name, codes)
    classes = {name: found.pop(name) for name in CLASSES if name in found}
    return {**classes, **found}
