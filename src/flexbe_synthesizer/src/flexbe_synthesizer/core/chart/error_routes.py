"""The map of `ext:on_error`: `100-199: Look again; 305: failed`."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

from flexbe_synthesizer.core.chart.model import ErrorRoute

ROUTES_RULE = (
    "'CODE: target' or 'FIRST-LAST: target', several parted by ';', with codes from 1 to 32767 "
    "(an int16 on the wire) of which each stands once"
)
_ROUTE = re.compile(r"\s*([0-9]{1,5})\s*(?:-\s*([0-9]{1,5})\s*)?:\s*(\S(?:.*\S)?)\s*\Z", re.DOTALL)
_LARGEST = 32767
FAILED_EVENT = "failed"
# The second spelling is that of behaviors generated before 1.0: `failed 100-199`.
_EVENT = re.compile(r"failed_([0-9]{1,5})(?:_([0-9]{1,5}))?|failed ([0-9]{1,5})(?:-([0-9]{1,5}))?")


def parse_routes(text: str) -> tuple[ErrorRoute, ...]:
    """Return the routes that a text spells, in its order.

    Raises:
        ValueError: if it does not follow ROUTES_RULE.
    """
    routes = tuple(map(_parse_route, text.split(";")))
    ordered = sorted(routes, key=lambda route: route.first)
    if any(before.last >= after.first for before, after in itertools.pairwise(ordered)):
        raise ValueError(text)
    return routes


def _parse_route(text: str) -> ErrorRoute:
    found = _ROUTE.match(text)
    if found is None:
        raise ValueError(text)
    first, last = int(found[1]), int(found[2] or found[1])
    if not 1 <= first <= last <= _LARGEST:
        raise ValueError(text)
    return ErrorRoute(first, last, found[3])


def format_routes(routes: tuple[ErrorRoute, ...]) -> str:
    """Return the text that `parse_routes` reads as these routes."""
    return "; ".join(f"{_codes(route)}: {route.target}" for route in routes)


def respelled(spelled: str, routes: tuple[ErrorRoute, ...]) -> str:
    """Return the routes as text, those that a text spells already as they stand there."""
    pieces = spelled.split(";")
    try:
        old = parse_routes(spelled)
    except ValueError:
        return format_routes(routes)
    head = _same(old, routes)
    tail = min(_same(old[::-1], routes[::-1]), min(len(old), len(routes)) - head)
    middle = []
    for index in range(head, len(routes) - tail):
        blanks = re.match(r"\s*", pieces[index] if index < len(old) - tail else " ")
        lead = blanks[0] if blanks and index else ""
        middle.append(lead + format_routes(routes[index : index + 1]))
    return ";".join((*pieces[:head], *middle, *pieces[len(pieces) - tail :]))


def _same(one: Sequence[ErrorRoute], other: Sequence[ErrorRoute]) -> int:
    """Return how many routes are the same at the beginning."""
    pairs = itertools.takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False))
    return sum(1 for _pair in pairs)


def route_event(route: ErrorRoute) -> str:
    """Return the name of a route among the events of its state: `failed_100_199`.

    It has no blank, because the FlexBE App drops the blanks of a state's outcomes.
    """
    return f"{FAILED_EVENT}_{_codes(route).replace('-', '_')}"


def _codes(route: ErrorRoute) -> str:
    return format_codes(route.first, route.last)


def format_codes(first: int, last: int) -> str:
    """Return a range of codes as `ext:on_error` spells it: `305`, `100-199`."""
    return str(first) if first == last else f"{first}-{last}"


def read_route_event(text: str) -> tuple[int, int] | None:
    """Return first and last code of the route that has the name, None if it is no such name."""
    found = _EVENT.fullmatch(text)
    if found is None:
        return None
    first, last = found[1] or found[3], found[2] or found[4]
    return int(first), int(last or first)
