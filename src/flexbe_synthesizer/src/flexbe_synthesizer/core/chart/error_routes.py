"""The map of `ext:on_error`: `INSERTION_JAMMED: Withdraw; 100-199: Look again`.

A name stands for one error code, or for a class of them; the table of names comes with the library
(`Library.error_names`). A failure takes the first route that has its code.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from flexbe_synthesizer.core.chart.model import ErrorRoute

LARGEST_CODE = 32767
ROUTES_RULE = (
    "'CODE: target', 'FIRST-LAST: target' or 'NAME: target', several parted by ';', with codes "
    f"from 1 to {LARGEST_CODE} (an int16 on the wire) and names of error codes or of classes of "
    "them, of which each stands once"
)
FAILED_EVENT = "failed"
_NUMBERS = r"([0-9]{1,5})\s*(?:-\s*([0-9]{1,5})\s*)?"
_WORD = r"[A-Za-z][A-Za-z0-9_]*"
_ROUTE = re.compile(rf"\s*(?:{_NUMBERS}|({_WORD})\s*):\s*(\S(?:.*\S)?)\s*\Z", re.DOTALL)
# The second spelling is that of behaviors generated before 1.0: `failed 100-199`.
_EVENT = re.compile(
    rf"failed_([0-9]{{1,5}})(?:_([0-9]{{1,5}}))?|failed ([0-9]{{1,5}})(?:-([0-9]{{1,5}}))?"
    rf"|failed_({_WORD})"
)


def parse_routes(text: str) -> tuple[ErrorRoute, ...]:
    """Return the routes that a text spells, in its order.

    Raises:
        ValueError: if it does not follow ROUTES_RULE.
    """
    routes = tuple(map(_parse_route, text.split(";")))
    ranges = sorted(filter(None, (_range(route.codes) for route in routes)))
    if any(before[1] >= after[0] for before, after in itertools.pairwise(ranges)):
        raise ValueError(text)
    if len({route.codes for route in routes}) < len(routes):
        raise ValueError(text)
    return routes


def _parse_route(text: str) -> ErrorRoute:
    found = _ROUTE.match(text)
    if found is None:
        raise ValueError(text)
    if found[3]:
        return ErrorRoute(found[3], found[4])
    first, last = int(found[1]), int(found[2] or found[1])
    if not 1 <= first <= last <= LARGEST_CODE:
        raise ValueError(text)
    return ErrorRoute(_spelled(first, last), found[4])


def is_error_name(text: str) -> bool:
    """Return whether a text can name an error code, or a class of them, in a route."""
    return re.fullmatch(_WORD, text) is not None


def is_named(route: ErrorRoute) -> bool:
    """Return whether a route names its codes, so that a table has to resolve them."""
    return _range(route.codes) is None


def _range(codes: str) -> tuple[int, int] | None:
    """Return the first and last of codes that are spelled as numbers; None of a name."""
    first, _, last = codes.partition("-")
    return (int(first), int(last or first)) if first.isdecimal() else None


def _spelled(first: int, last: int) -> str:
    return str(first) if first == last else f"{first}-{last}"


def codes_of_routes(
    routes: Iterable[ErrorRoute], error_names: Mapping[str, Collection[int]]
) -> tuple[tuple[int, ...], ...]:
    """Return the codes that each route takes, ascending: those that no route before it has.

    Args:
        routes: in their order.
        error_names: codes by the names of codes and classes; an unknown name has none.
    """
    taken: set[int] = set()
    found = []
    for route in routes:
        numbers = _range(route.codes)
        codes = range(numbers[0], numbers[1] + 1) if numbers else error_names.get(route.codes, ())
        found.append(tuple(sorted(set(codes) - taken)))
        taken.update(codes)
    return tuple(found)


def spans(codes: Iterable[int]) -> tuple[tuple[int, int], ...]:
    """Return first and last of each row of ascending numbers without a gap."""
    found: list[tuple[int, int]] = []
    for code in codes:
        if found and found[-1][1] == code - 1:
            found[-1] = (found[-1][0], code)
        else:
            found.append((code, code))
    return tuple(found)


def format_codes(codes: Iterable[int]) -> str:
    """Return ascending codes in numbers: `3-5, 7-10, 305`."""
    return ", ".join(_spelled(*span) for span in spans(codes))


def format_routes(routes: Iterable[ErrorRoute]) -> str:
    """Return the text that `parse_routes` reads as these routes."""
    return "; ".join(f"{route.codes}: {route.target}" for route in routes)


def respelled(spelled: str, routes: tuple[ErrorRoute, ...]) -> str:
    """Return the routes as text, those that a text spells already as they stand there."""
    pieces = spelled.split(";")
    try:
        old = parse_routes(spelled)
    except ValueError:
        return format_routes(routes)
    head, tail = common_ends(old, routes)
    middle = []
    for index in range(head, len(routes) - tail):
        blanks = re.match(r"\s*", pieces[index] if index < len(old) - tail else " ")
        lead = blanks[0] if blanks and index else ""
        middle.append(lead + format_routes(routes[index : index + 1]))
    return ";".join((*pieces[:head], *middle, *pieces[len(pieces) - tail :]))


def common_ends(one: Sequence[object], other: Sequence[object]) -> tuple[int, int]:
    """Return how many items are the same at the beginning, and how many others at the end."""
    counts = []
    for pairs in (zip(one, other, strict=False), zip(one[::-1], other[::-1], strict=False)):
        counts.append(sum(1 for _ in itertools.takewhile(lambda pair: pair[0] == pair[1], pairs)))
    head, tail = counts
    return head, min(tail, min(len(one), len(other)) - head)


def route_event(route: ErrorRoute) -> str:
    """Return the name of a route among the events of its state: `failed_100_199`.

    It has no blank, because the FlexBE App drops the blanks of a state's outcomes.
    """
    return f"{FAILED_EVENT}_{route.codes.replace('-', '_')}"


def codes_of_event(text: str) -> str | None:
    """Return the codes, as a route spells them, of the route event; None if it is no such name."""
    found = _EVENT.fullmatch(text)
    if found is None:
        return None
    if found[5]:
        return found[5]
    first, last = found[1] or found[3], found[2] or found[4]
    return _spelled(int(first), int(last or first))


# The names of error codes, and of classes of codes, that `ext:on_error` may use


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
        for row in _section(fault, "codes"):
            found.append(
                ListedCode(*_checked(row), fault.get("severity"), fault.get("first_level"))
            )
    return tuple(found)


def _section(table: Mapping[str, object], name: str) -> Iterable[object]:
    """Return the rows of a section of a table, or of a fault; none if it is missing."""
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
