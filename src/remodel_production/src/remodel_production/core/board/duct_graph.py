"""The shortest routes through ducts, between points on them.

A point on a duct lies on a segment between two nodes. Routes between nodes are found by Dijkstra's
algorithm (Numerische Mathematik 1, 1959), once for each node that is asked for; of equally short
routes the one over nodes that were given first is taken.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict

from remodel_production.core.production import Node, Segment

_Point = tuple[float, float]
_EXACT_M = 1e-6


class DuctGraph:
    """Nodes and straight segments in a plane, along x or along y."""

    def __init__(self, nodes: tuple[Node, ...], segments: tuple[Segment, ...]) -> None:
        """Index a graph; each node has a position."""
        self._at = {node.name: node.position[:2] for node in nodes if node.position is not None}
        self._rank = {node.name: rank for rank, node in enumerate(nodes)}
        self._segments = segments
        self._beside: dict[str, list[tuple[str, Segment]]] = defaultdict(list)
        self._level: dict[float, list[Segment]] = defaultdict(list)
        for segment in segments:
            self._beside[segment.start].append((segment.end, segment))
            self._beside[segment.end].append((segment.start, segment))
            start, end = self._at[segment.start], self._at[segment.end]
            if start[1] == end[1]:
                self._level[start[1]].append(segment)
        self._routes: dict[str, dict[str, tuple[float, tuple[str, ...]]]] = {}

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
            for end in (last.start, last.end):
                if end not in self._from(start):
                    continue
                length, route = self._from(start)[end]
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

    def _from(self, start: str) -> dict[str, tuple[float, tuple[str, ...]]]:
        """Return the length and the segments of the shortest route to each node."""
        if start not in self._routes:
            found: dict[str, tuple[float, tuple[str, ...]]] = {}
            queue: list[tuple[float, int, str, tuple[str, ...]]] = [(0.0, 0, start, ())]
            while queue:
                length, _, node, route = heapq.heappop(queue)
                if node in found:
                    continue
                found[node] = (length, route)
                for other, segment in self._beside[node]:
                    if other not in found:
                        total = round(length + segment.length_m, 9)
                        step = (total, self._rank[other], other, (*route, segment.name))
                        heapq.heappush(queue, step)
            self._routes[start] = found
        return self._routes[start]
