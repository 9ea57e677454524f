"""Lay out a cabinet: components in rows on rails, ducts around the rows, wires through the ducts.

A point on a duct lies on a segment between two nodes. Routes between nodes are found by Dijkstra's
algorithm (Numerische Mathematik 1, 1959), once for each node that is asked for; of equally short
routes the one over nodes that were given first is taken, and then the first by the segments' names.

    ─── D0 ───┬  Ducts lie above each row and below the last one, and up both sides. Each is cut
    │ Q1  Q2  │  into segments between nodes. A wire leaves its terminal up or down into the duct
    ├── D1 ───┤  there, takes the shortest route through the ducts' graph, and leaves it in the same
    │ X1  K1  │  manner.
    └── D2 ───┘

Components keep the places that the design gives, if it gives one to each of them. Else they are put
in a line in which those that are wired to each other are near, and the line is broken into rows.
All of it is deterministic. Frame: x to the right, y up, z out of the plate; origin at the plate's
lower left corner.
"""

from __future__ import annotations

import heapq
import math
from array import array
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from remodel_production.core.board.formboard import with_trunk
from remodel_production.core.catalogue import CabinetRules, Catalogue
from remodel_production.core.production import (
    Component,
    Node,
    Order,
    Pose,
    Segment,
    SegmentKind,
    Side,
    TerminalRef,
    Vector,
)

_Point = tuple[float, float]
_EXACT_M = 1e-6
_NONE = -1


@dataclass(frozen=True)
class _Tree:
    """The shortest routes from one node: with thousands of wires there are a million of them.

    Attributes:
        lengths: [m] to each node, by its rank; infinite for one that no route leads to.
        last: the last segment on the route to each node, by its number.
    """

    lengths: array[float]
    last: array[int]


class DuctGraph:
    """Nodes and straight segments in a plane, along x or along y."""

    def __init__(self, nodes: tuple[Node, ...], segments: tuple[Segment, ...]) -> None:
        """Index a graph; each node has a position."""
        self._at = {node.name: node.position[:2] for node in nodes if node.position is not None}
        self._rank = {node.name: rank for rank, node in enumerate(nodes)}
        self._segments = segments
        self._ends = [(self._rank[each.start], self._rank[each.end]) for each in segments]
        self._beside: list[list[tuple[int, int]]] = [[] for _ in nodes]
        self._level: dict[float, list[Segment]] = defaultdict(list)
        for number, segment in enumerate(segments):
            first, second = self._ends[number]
            self._beside[first].append((second, number))
            self._beside[second].append((first, number))
            start, end = self._at[segment.start], self._at[segment.end]
            if start[1] == end[1]:
                self._level[start[1]].append(segment)
        self._trees: dict[int, _Tree] = {}

    def shortest_route(self, a: _Point, b: _Point) -> tuple[tuple[str, ...], float]:
        """Return the segments from one point to another, and the length [m] between them.

        Args:
            a: a point on a segment along x.
            b: another one.
        """
        first, last = self._segment_at(a), self._segment_at(b)
        if first is last:
            return (first.name,), math.dist(a, b)
        best: tuple[float, int, int, tuple[str, ...]] | None = None
        for start in (first.start, first.end):
            tree = self._from(self._rank[start])
            for end in (last.start, last.end):
                length = tree.lengths[self._rank[end]]
                if math.isinf(length):
                    continue
                route = self._route(tree, self._rank[end])
                # A route over the far node of its own segment would pass it twice.
                if first.name in route or last.name in route:
                    continue
                total = math.dist(a, self._at[start]) + length + math.dist(self._at[end], b)
                found = (round(total, 9), self._rank[start], self._rank[end], route)
                best = found if best is None else min(best, found)
        if best is None:
            raise ValueError(f"ducts do not lead from {a} to {b}")
        return (first.name, *best[3], last.name), best[0]

    def _segment_at(self, point: _Point) -> Segment:
        x, y = point
        for segment in self._level[y]:
            low, high = sorted((self._at[segment.start][0], self._at[segment.end][0]))
            if low - _EXACT_M <= x <= high + _EXACT_M:
                return segment
        raise ValueError(f"no duct at {point}")

    def _from(self, start: int) -> _Tree:
        """Return the shortest routes from a node to all others."""
        if start not in self._trees:
            count = len(self._beside)
            tree = _Tree(array("d", [math.inf]) * count, array("i", [_NONE]) * count)
            tree.lengths[start] = 0.0
            queue = [(0.0, start)]
            is_final = bytearray(count)
            while queue:
                length, node = heapq.heappop(queue)
                if is_final[node]:
                    continue
                is_final[node] = True
                for other, segment in self._beside[node]:
                    if is_final[other]:
                        continue
                    total = round(length + self._segments[segment].length_m, 9)
                    if total < tree.lengths[other]:
                        heapq.heappush(queue, (total, other))
                    elif total > tree.lengths[other] or not self._is_before(
                        tree, node, segment, other
                    ):
                        continue
                    tree.lengths[other], tree.last[other] = total, segment
            self._trees[start] = tree
        return self._trees[start]

    def _is_before(self, tree: _Tree, node: int, segment: int, other: int) -> bool:
        """Return whether a route over a node and a segment counts before another one as short."""
        route = (*self._route(tree, node), self._segments[segment].name)
        return route < self._route(tree, other)

    def _route(self, tree: _Tree, node: int) -> tuple[str, ...]:
        """Return the segments of the shortest route to a node."""
        names = []
        while (segment := tree.last[node]) != _NONE:
            names.append(self._segments[segment].name)
            first, second = self._ends[segment]
            node = first if second == node else second
        return tuple(reversed(names))


# How often those that are wired to each other are pulled together.
_PASSES = 40


def laid_out(order: Order, catalogue: Catalogue) -> Order:
    """Return the order with the places, ducts, routes and lengths that its design leaves open.

    A design with segments of its own, such as a harness, is returned unchanged; a harness between
    two rows of connectors gets a trunk. Wires that leave the cabinet get no route, and components
    outside it no place.
    """
    inside = order.in_cabinet()
    if order.segments or not inside.wires:
        return order
    harness = with_trunk(order, catalogue)
    if harness is not None:
        return harness
    return _Cabinet(order, inside, catalogue).order()


@dataclass(frozen=True)
class _Row:
    """A row by the height of its rail, and its components with their centres from left to right."""

    y: float
    places: tuple[tuple[Component, float], ...]


class _Cabinet:
    """Lays out one order; every method fills what the next one needs."""

    def __init__(self, order: Order, inside: Order, catalogue: Catalogue) -> None:
        self._order = order
        self._catalogue = catalogue
        self._rules = catalogue.cabinet
        self._pitches = clamp_pitches(order, catalogue)
        used = {component.name for component in inside.components}
        # With all their terminals, also those of wires that leave the cabinet.
        self._members = [c for c in order.components if c.name in used]
        self._widths = {c.name: device_width(c, self._pitches, self._rules) for c in self._members}
        self._wires = inside.wires
        posed = all(component.pose is not None for component in self._members)
        self._rows = self._given_rows() if posed else self._computed_rows()
        lefts = [x - self._width(c) / 2 for row in self._rows for c, x in row.places]
        rights = [x + self._width(c) / 2 for row in self._rows for c, x in row.places]
        self._left = min(lefts) - self._rules.duct.width
        self._right = max(rights) + self._rules.duct.width
        self._ducts = self._duct_heights()

    def order(self) -> Order:
        places: dict[str, Component] = {}
        taps: dict[TerminalRef, tuple[float, int]] = {}
        openings: dict[TerminalRef, tuple[float, float]] = {}
        for index, row in enumerate(self._rows):
            for component, x in row.places:
                placed = self._placed(component, x, row.y)
                places[component.name] = placed
                for terminal in placed.terminals:
                    ref = TerminalRef(component.name, terminal.name)
                    dx, dy, _ = _position(terminal.pose)
                    openings[ref] = (x + dx, row.y + dy)
                    taps[ref] = (x + dx, index + (terminal.side is Side.BOTTOM))
        nodes, segments = self._graph()
        graph = DuctGraph(nodes, segments)
        wires = []
        routed = {wire.name for wire in self._wires}
        for wire in self._order.wires:
            if wire.name not in routed:
                wires.append(wire)
                continue
            (ax, a_duct), (bx, b_duct) = taps[wire.a], taps[wire.b]
            ay, by = self._ducts[a_duct], self._ducts[b_duct]
            route, length = graph.shortest_route((ax, ay), (bx, by))
            down = abs(openings[wire.a][1] - ay) + abs(openings[wire.b][1] - by)
            needed = round(length + down + 2 * self._rules.tail, 3)
            wires.append(replace(wire, route=route, length_m=wire.length_m or self._cut(needed)))
        return replace(
            self._order,
            components=tuple(places.get(c.name, c) for c in self._order.components),
            wires=tuple(wires),
            nodes=nodes,
            segments=segments,
        )

    def _cut(self, needed: float) -> float:
        """Return to which length a wire is cut of which so much is needed [m]."""
        rules = self._rules
        is_cut_longer = rules.shortest - rules.slack <= needed < rules.shortest
        return rules.shortest if is_cut_longer else needed

    def _width(self, component: Component) -> float:
        return self._widths[component.name]

    def _depth(self, component: Component) -> float:
        return self._catalogue.device_class(component).depth_m

    def _given_rows(self) -> list[_Row]:
        """Return the rows by the places of the design: those at about one height are one row."""
        placed = [(component, *_position(component.pose)[:2]) for component in self._members]
        placed.sort(key=lambda place: (-place[2], place[1], place[0].name))
        rows: list[_Row] = []
        depth = max(self._depth(component) for component in self._members)
        for component, x, y in placed:
            if rows and rows[-1].y - y < depth:
                rows[-1] = replace(rows[-1], places=(*rows[-1].places, (component, x)))
            else:
                rows.append(_Row(y, ((component, x),)))
        return [
            replace(row, places=tuple(sorted(row.places, key=lambda place: place[1])))
            for row in rows
        ]

    def _computed_rows(self) -> list[_Row]:
        line = self._line()
        total = sum(self._width(component) + self._rules.device_gap for component in line)
        widest = max(self._width(component) for component in line)
        width = max(widest, math.sqrt(total * self._rules.row_pitch * self._rules.aspect))
        count = max(1, math.ceil(total / width))
        rows: list[list[Component]] = [[]]
        filled = 0.0
        for component in line:
            own = self._width(component) + self._rules.device_gap
            # Rows end where their share of the whole is over, so that all are about as long.
            if rows[-1] and filled + own / 2 > total * len(rows) / count:
                rows.append([])
            rows[-1].append(component)
            filled += own
        height = len(rows) * self._rules.row_pitch
        left = self._rules.duct.width
        return [
            _Row(height - (index + 0.5) * self._rules.row_pitch, self._along(members, left))
            for index, members in enumerate(rows)
        ]

    def _along(
        self, members: Sequence[Component], x: float = 0.0
    ) -> tuple[tuple[Component, float], ...]:
        """Return components in a row with their centres, from x on [m]."""
        places = []
        for component in members:
            width = self._width(component)
            places.append((component, x + width / 2))
            x += width + self._rules.device_gap
        return tuple(places)

    def _line(self) -> list[Component]:
        """Return the components in a line, those that are wired to each other near each other.

        Each is drawn towards the mean of those that it is wired to; of all lines tried, the one
        with the least distance between wired ones is taken. The first one is that of the design.
        """
        partners: dict[str, list[str]] = defaultdict(list)
        for wire in self._wires:
            a, b = wire.a.component, wire.b.component
            if a != b:
                partners[a].append(b)
                partners[b].append(a)
        line = list(self._members)
        best, least = line, math.inf
        for _ in range(_PASSES):
            place = {component.name: x for component, x in self._along(line)}
            distance = sum(
                abs(place[wire.a.component] - place[wire.b.component]) for wire in self._wires
            )
            if distance < least - 1e-9:
                best, least = line, distance
            pull = {
                name: sum(place[other] for other in others) / len(others)
                for name, others in partners.items()
            }
            line = sorted(line, key=lambda c: (place[c.name] + pull.get(c.name, place[c.name])) / 2)
        return best

    def _placed(self, component: Component, x: float, y: float) -> Component:
        """Return a component with its own pose and those of its terminals."""
        terminals = {}
        for side in Side:
            members = [t for t in component.terminals if t.side is side]
            up = 1 if side is Side.TOP else -1
            pitches = [self._pitches[TerminalRef(component.name, t.name)] for t in members]
            left = -sum(pitches) / 2
            for terminal, pitch in zip(members, pitches, strict=True):
                dx, left = left + pitch / 2, left + pitch
                opening = Pose((round(dx, 6), up * self._depth(component) / 2, 0.0))
                terminals[terminal.name] = replace(
                    terminal,
                    pose=terminal.pose or opening,
                    approach=terminal.approach or (0.0, -float(up), 0.0),
                )
        return replace(
            component,
            pose=component.pose or Pose((round(x, 6), round(y, 6), 0.0)),
            terminals=tuple(terminals[terminal.name] for terminal in component.terminals),
        )

    def _duct_heights(self) -> list[float]:
        """Return y of the horizontal ducts, from the upmost."""
        ys = [row.y for row in self._rows]
        half = self._rules.row_pitch / 2
        between = [(above + below) / 2 for above, below in pairwise(ys)]
        return [round(y, 6) for y in (ys[0] + half, *between, ys[-1] - half)]

    def _graph(self) -> tuple[tuple[Node, ...], tuple[Segment, ...]]:
        width = self._right - self._left
        pieces = max(1, math.ceil(width / self._rules.duct_piece))
        nodes, segments = [], []
        for k, y in enumerate(self._ducts):
            for j in range(pieces + 1):
                x = self._left + width * j / pieces
                nodes.append(Node(f"D{k}/{j}", (round(x, 6), y, 0.0)))
            for j in range(pieces):
                piece = round(width / pieces, 6)
                start, end = f"D{k}/{j}", f"D{k}/{j + 1}"
                segments.append(Segment(f"D{k}.{j}", start, end, piece, kind=SegmentKind.DUCT))
        for k, (above, below) in enumerate(pairwise(self._ducts)):
            for name, j in (("L", 0), ("R", pieces)):
                start, end = f"D{k}/{j}", f"D{k + 1}/{j}"
                length = round(above - below, 6)
                segments.append(Segment(f"{name}{k}", start, end, length, kind=SegmentKind.DUCT))
        return tuple(nodes), tuple(segments)


def clamp_pitches(order: Order, catalogue: Catalogue) -> dict[TerminalRef, float]:
    """Return the pitch [m] of each terminal, by the section of its wire."""
    sections = {end: wire.section_mm2 for wire in order.wires for end in (wire.a, wire.b)}
    return {
        (ref := TerminalRef(component.name, terminal.name)): catalogue.clamp(
            sections.get(ref, catalogue.default_section)
        ).pitch_m
        for component in order.components
        for terminal in component.terminals
    }


def device_width(
    component: Component, pitches: Mapping[TerminalRef, float], rules: CabinetRules
) -> float:
    """Return the width [m] of a device: of its wider row of terminals, with its margins."""
    rows = (
        sum(
            pitches[TerminalRef(component.name, t.name)] for t in component.terminals if t.side is s
        )
        for s in Side
    )
    return max(max(rows) + 2 * rules.device_margin, rules.narrowest)


def is_cabinet(order: Order) -> bool:
    """Return whether an order has ducts, as `laid_out` makes them."""
    return any(segment.kind is SegmentKind.DUCT for segment in order.segments)


def _position(pose: Pose | None) -> Vector:
    return (0.0, 0.0, 0.0) if pose is None else pose.position
