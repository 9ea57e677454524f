"""Where all parts of an order are, in the plane that is wired; lengths checked against it."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from remodel_production.core.board.cabinet import clamp_pitches, is_cabinet, laid_out
from remodel_production.core.board.facing import Stand, row_of, too_long
from remodel_production.core.board.formboard import Point, flattened
from remodel_production.core.catalogue import CabinetRules, Catalogue, reasons_by_wire
from remodel_production.core.production import (
    Component,
    Order,
    Role,
    Segment,
    SegmentKind,
    Side,
    TerminalRef,
    Wire,
)

# Nodes that lie so near to a line are on it [m].
_STRAIGHT_M = 1e-6


@dataclass(frozen=True)
class PlacedDevice:
    """A component as a rectangle [m]: its centre and its size.

    Attributes:
        turn: by which it is turned to the left, with its size and its sides [rad].
    """

    component: Component
    centre: Point
    size: tuple[float, float]
    turn: float = 0.0

    @property
    def half_extent(self) -> tuple[float, float]:
        """How far it reaches from its centre, along x and y [m]."""
        cos, sin = abs(math.cos(self.turn)), abs(math.sin(self.turn))
        width, depth = self.size
        return (cos * width + sin * depth) / 2, (sin * width + cos * depth) / 2


@dataclass(frozen=True)
class Board:
    """The board of an order; lengths in [m], x to the right, y up.

    Attributes:
        order: with all places and routes.
        openings: of the terminals.
        lines: ends of the segments, by name.
        clips: places of the clips, by name.
        routes: of the wires on the board, by name, from end a to end b.
        is_cabinet: whether the segments are ducts.
        full: why wires are by hand that a terminal has no place for, by their names.
    """

    order: Order
    devices: tuple[PlacedDevice, ...]
    openings: Mapping[TerminalRef, Point]
    lines: Mapping[str, tuple[Point, Point]]
    clips: Mapping[str, Point]
    routes: Mapping[str, tuple[Point, ...]]
    is_cabinet: bool
    full: Mapping[str, str] = field(default_factory=dict)

    def length_of(self, wire: Wire) -> float:
        """Return the length [m] of a wire, or that of its route if the design does not say."""
        return route_length(self.routes[wire.name]) if wire.length_m is None else wire.length_m


def route_length(route: tuple[Point, ...]) -> float:
    """Return the length [m] of a polyline."""
    return sum(math.dist(p, q) for p, q in pairwise(route))


def board_of(order: Order, catalogue: Catalogue) -> Board:
    """Return the board of an order: a plate with ducts, or a formboard for a harness.

    Wires that leave the board are not on it.
    """
    order = laid_out(order, catalogue)
    has_ducts = is_cabinet(order)
    make = _plate if has_ducts or not order.segments else _formboard
    return replace(make(order, catalogue), full=reasons_by_wire(order.in_cabinet(), catalogue))


def _plate(order: Order, catalogue: Catalogue) -> Board:
    inside = order.in_cabinet()
    whole = {component.name: component for component in order.components}
    pitches = clamp_pitches(order, catalogue)
    nodes = {n.name: n.position[:2] for n in order.nodes if n.position is not None}
    devices, openings = [], {}
    for component in inside.components:
        if component.pose is None:
            continue
        x, y, _ = component.pose.position
        # With the terminals of wires that leave the cabinet, too.
        spots = {t.name: t.pose.position for t in whole[component.name].terminals if t.pose}
        for terminal in component.terminals:
            dx, dy, _ = terminal.pose.position if terminal.pose else (0.0, 0.0, 0.0)
            openings[TerminalRef(component.name, terminal.name)] = (x + dx, y + dy)
        reaches = [
            abs(dx) + pitches[TerminalRef(component.name, name)] / 2
            for name, (dx, _, _) in spots.items()
        ]
        rules = catalogue.cabinet
        width = max(2 * (max(reaches, default=0.0) + rules.device_margin), rules.narrowest)
        part = catalogue.device_class(component)
        height = 2 * max((abs(dy) for _, dy, _ in spots.values()), default=part.depth_m / 2)
        devices.append(PlacedDevice(component, (x, y), (round(width, 6), round(height, 6))))
    lines = {s.name: (nodes[s.start], nodes[s.end]) for s in order.segments}
    routes = {w.name: _through_ducts(order, w, openings, lines) for w in inside.wires}
    return Board(order, tuple(devices), openings, lines, clips={}, routes=routes, is_cabinet=True)


def _through_ducts(
    order: Order,
    wire: Wire,
    openings: Mapping[TerminalRef, Point],
    lines: Mapping[str, tuple[Point, Point]],
) -> tuple[Point, ...]:
    """Return a wire's route: up or down into a duct, from node to node, and out of a duct."""
    a, b = openings[wire.a], openings[wire.b]
    if not wire.route:
        return a, b
    into, out = lines[wire.route[0]][0][1], lines[wire.route[-1]][0][1]
    route = order.directed_route(wire)
    nodes = [lines[segment.name][1 if is_forward else 0] for segment, is_forward in route[:-1]]
    return _straightened((a, (a[0], into), *nodes, (b[0], out), b))


def _formboard(order: Order, catalogue: Catalogue) -> Board:
    nodes = _node_places(order)
    pitch = catalogue.formboard.cavity_pitch
    left = min(x for x, _ in nodes.values())
    low = min(y for _, y in nodes.values())
    devices, openings = [], {}
    loose_x = left
    at_node: Counter[str] = Counter()
    standing = _standing(order, nodes, catalogue)
    for component in order.components:
        if component.name in standing:
            device, of_device = standing[component.name]
            devices.append(device)
            openings.update(of_device)
            continue
        depth = catalogue.device_class(component).depth_m
        size = (max(1, len(component.terminals)) * pitch, depth)
        centre = nodes.get(component.node)
        if centre is None:
            # The design says no node: it lies below the harness.
            centre = (loose_x + size[0] / 2, low - 4 * depth)
            loose_x += size[0] + depth
        else:
            # Of those at one node, each lies below the one before.
            below = at_node[component.node] * 1.2 * depth
            at_node[component.node] += 1
            centre = (centre[0], centre[1] - below)
        devices.append(PlacedDevice(component, centre, size))
        for index, terminal in enumerate(component.terminals):
            x = centre[0] + (index - (len(component.terminals) - 1) / 2) * pitch
            up = 1 if terminal.side is Side.TOP else -1
            opening = (x, centre[1] + up * depth / 2)
            openings[TerminalRef(component.name, terminal.name)] = opening
    lines = {s.name: (nodes[s.start], nodes[s.end]) for s in order.segments}
    clips = {
        clip.name: nodes[clip.node] if clip.node else _along(lines[clip.segment], clip.along)
        for clip in order.clips
    }
    routes = {wire.name: _along_bundles(order, wire, openings, nodes) for wire in order.wires}
    return Board(
        order, tuple(devices), openings, lines, clips=clips, routes=routes, is_cabinet=False
    )


def _node_places(order: Order) -> Mapping[str, Point]:
    """Return where the nodes of a harness are: given for straight segments, else laid out."""
    if all(segment.kind is SegmentKind.STRAIGHT for segment in order.segments):
        return {n.name: n.position[:2] for n in order.nodes if n.position is not None}
    return flattened([node.name for node in order.nodes], order.segments)


def _standing(
    order: Order, nodes: Mapping[str, Point], catalogue: Catalogue
) -> dict[str, tuple[PlacedDevice, dict[TerminalRef, Point]]]:
    """Return the connectors at the ends of bundles, which open towards them, and their openings."""
    rules = catalogue.formboard
    bundles = defaultdict(list)
    # Connectors at the ends of straight segments face each other.
    facing = {
        node
        for segment in order.segments
        if segment.kind is SegmentKind.STRAIGHT
        for node in (segment.start, segment.end)
    }
    for segment in order.segments:
        bundles[segment.start].append(segment.end)
        bundles[segment.end].append(segment.start)
    at = defaultdict(list)
    for component in order.components:
        node = component.node
        if component.role is Role.CONNECTOR and (node in facing or len(bundles[node]) == 1):
            at[component.node].append(component)
    found = {}
    for node, components in at.items():
        (x, y), (to_x, to_y) = nodes[node], nodes[bundles[node][0]]
        heading = math.atan2(to_y - y, to_x - x)
        if node in facing:
            heading = 0.0 if to_x > x else math.pi
        stand = Stand((x, y), heading)
        row = row_of(components, rules.cavity_pitch, rules.connector_gap)
        for component in components:
            depth = catalogue.device_class(component).depth_m
            centre = stand.place(row.middles[component.name], depth / 2)
            size = (row.widths[component.name], depth)
            refs = [TerminalRef(component.name, terminal.name) for terminal in component.terminals]
            found[component.name] = (
                PlacedDevice(component, centre, size, stand.turn),
                {ref: stand.place(row.cavities[ref], 0.0) for ref in refs},
            )
    return found


def _along_bundles(
    order: Order, wire: Wire, openings: Mapping[TerminalRef, Point], nodes: Mapping[str, Point]
) -> tuple[Point, ...]:
    route: list[tuple[Segment, bool]] = order.directed_route(wire) if wire.route else []
    passed = []
    for index, (segment, is_forward) in enumerate(route):
        first, last = (segment.start, segment.end)[:: 1 if is_forward else -1]
        passed += [nodes[first], nodes[last]] if not index else [nodes[last]]
    # Through bundles in one line a wire runs straight from opening to opening.
    is_free = all(segment.kind is SegmentKind.STRAIGHT for segment, _ in route)
    if passed and (is_free or _is_straight(passed)):
        passed = []
    return (openings[wire.a], *passed, openings[wire.b])


def _is_straight(points: Sequence[Point]) -> bool:
    (x, y), (to_x, to_y) = points[0], points[-1]
    length = math.hypot(to_x - x, to_y - y)
    aside = [abs((to_x - x) * (q - y) - (to_y - y) * (p - x)) / length for p, q in points[1:-1]]
    return max(aside, default=0.0) < _STRAIGHT_M


def _along(line: tuple[Point, Point], along: float) -> Point:
    (x1, y1), (x2, y2) = line
    return x1 + along * (x2 - x1), y1 + along * (y2 - y1)


def _straightened(points: tuple[Point, ...]) -> tuple[Point, ...]:
    """Return a polyline along the axes without points at which it goes straight on."""
    kept: list[Point] = []
    for point in points:
        if kept and kept[-1] == point:
            continue
        if len(kept) > 1 and any(
            kept[-2][axis] == kept[-1][axis] == point[axis] for axis in (0, 1)
        ):
            kept[-1] = point
        else:
            kept.append(point)
    return tuple(kept)


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
