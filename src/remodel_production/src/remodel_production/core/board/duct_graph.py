"""The shortest routes through ducts, between points on them.

A point on a duct lies on a segment between two nodes. Routes between nodes are found by Dijkstra's
algorithm (Numerische Mathematik 1, 1959), once for each node that is asked for; of equally short
routes the one over nodes that were given first is taken, and then the first by the segments' names.
"""

from __future__ import annotations

import heapq
import math
from array import array
from collections import defaultdict
from dataclasses import dataclass

from remodel_production.core.production import Node, Segment

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
