"""The map of `ext:on_error`: `100-199: Look again; 305: failed`."""

from __future__ import annotations

import itertools
import re

from flexbe_synthesizer.core.model import ErrorRoute

ROUTES_RULE = (
    "'CODE: target' or 'FIRST-LAST: target', several parted by ';', with codes from 1 to 32767 "
    "(an int16 on the wire) of which each stands once"
)
_ROUTE = re.compile(r"\s*([0-9]{1,5})\s*(?:-\s*([0-9]{1,5})\s*)?:\s*(\S(?:.*\S)?)\s*\Z", re.DOTALL)
_LARGEST = 32767
FAILED_EVENT = "failed"
_EVENT = re.compile(r"failed ([0-9]{1,5})(?:-([0-9]{1,5}))?")


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
    return "; ".join(f"{route_codes(route)}: {route.target}" for route in routes)


def route_event(route: ErrorRoute) -> str:
    """Return the name of a route among the events of its state: `failed 100-199`."""
    return f"failed {route_codes(route)}"


def route_codes(route: ErrorRoute) -> str:
    """Return the range of a route: `304` or `100-199`."""
    return str(route.first) if route.first == route.last else f"{route.first}-{route.last}"


def read_route_event(text: str) -> tuple[int, int] | None:
    """Return first and last code of the route that has the name, None if it is no such name."""
    found = _EVENT.fullmatch(text)
    return None if found is None else (int(found[1]), int(found[2] or found[1]))
