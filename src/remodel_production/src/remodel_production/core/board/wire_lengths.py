"""Check the lengths that a design gives against the routes of its wires on the board."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from itertools import pairwise

from remodel_production.core.board.board import Board, route_length
from remodel_production.core.board.facing import too_long
from remodel_production.core.catalogue import CabinetRules
from remodel_production.core.production import SegmentKind

# A wire so much longer than its route is more likely a wrong unit than slack.
_MOST_TIMES = 3.0
_SLACK_M = 0.5
# Lengths are rounded to the millimetre.
_TOLERANCE_M = 0.001


def length_findings(board: Board, stated: Collection[str]) -> tuple[tuple[str, ...], ...]:
    """Return the wires that are too short for their routes, and those that are much too long.

    Args:
        board: with the routes.
        stated: names of the wires whose lengths are the design's.

    Returns:
        For each of the two kinds a line for a person about each wire, the worst first; then a line
        about each bundle for which the connectors of a formboard cannot stand, since it is longer
        than the others of a ring together.
    """
    lengths = {segment.name: segment.length_m for segment in board.order.segments}
    short: list[tuple[float, str]] = []
    long: list[tuple[float, str]] = []
    for wire in board.order.wires:
        route = board.routes.get(wire.name)
        if wire.name not in stated or route is None or wire.length_m is None:
            continue
        # The segments of a harness are its own; connectors add less than the layout draws.
        own = [] if board.is_cabinet else [lengths[name] for name in wire.route]
        needed = sum(own) if own else route_length(route)
        line = f"{wire.name}: {wire.length_m:.3g} m, its route {needed:.3g} m ({wire.source})"
        if wire.length_m < needed - _TOLERANCE_M:
            short.append((needed / wire.length_m, line))
        elif wire.length_m > _MOST_TIMES * needed + _SLACK_M:
            long.append((wire.length_m / max(needed, _TOLERANCE_M), line))
    about_wires = (
        tuple(line for _, line in sorted(found, reverse=True)) for found in (short, long)
    )
    return (*about_wires, tuple(_rings(board, stated)))


def cut_longer(board: Board, stated: Collection[str], rules: CabinetRules) -> tuple[str, ...]:
    """Return a line about each wire that is cut longer than needed, the one by the most first."""
    found = []
    for wire in board.order.wires:
        route = board.routes.get(wire.name)
        if wire.name in stated or route is None or wire.length_m != rules.shortest:
            continue
        needed = route_length(route) + 2 * rules.tail
        if needed < rules.shortest - _TOLERANCE_M:
            found.append((needed, f"{wire.name}: {wire.length_m:.3g} m, needed {needed:.3g} m"))
    return tuple(line for _, line in sorted(found)) if board.is_cabinet else ()


def _rings(board: Board, stated: Collection[str]) -> Iterator[str]:
    """Yield a line about each bundle that is longer than the others of a ring together."""
    if any(segment.kind is not SegmentKind.STRAIGHT for segment in board.order.segments):
        return
    wires = [wire for wire in board.order.wires if wire.name in stated]
    lengths: dict[frozenset[str], float] = {}
    for wire in wires:
        ends = frozenset((wire.a.component, wire.b.component))
        lengths[ends] = min(wire.length_m or math.inf, lengths.get(ends, math.inf))
    for (a, b), path in too_long(wires).items():
        others = [(p, q, lengths[frozenset((p, q))]) for p, q in pairwise(path)]
        ways = ", ".join(f"{p} to {q} {length:.3g} m" for p, q, length in others)
        total = sum(length for _, _, length in others)
        yield (
            f"{a} to {b}: {lengths[frozenset((a, b))]:.3g} m, and the way around it only "
            f"{total:.3g} m ({ways})"
        )
