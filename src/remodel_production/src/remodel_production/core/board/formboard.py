"""Lay out a harness on a formboard: its nodes in a plane, with the true lengths of its segments.

Of each connected part of the harness, the longest path through it is the trunk, which lies along x.
Every branch leaves its node at a right angle, up and down in turn; where it forks, its longer part
goes straight on. A segment that closes a ring of segments is not stretched out, but drawn straight
between its nodes.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from remodel_production.core.production import Segment

Point = tuple[float, float]
_Tree = dict[str, list[tuple[str, float]]]

# [m] between parts of a harness that do not hang together.
_BETWEEN_PARTS_M = 0.3


def flattened(nodes: Sequence[str], segments: Sequence[Segment]) -> dict[str, Point]:
    """Return the place [m] of each node; x to the right, y up."""
    places: dict[str, Point] = {}
    top = 0.0
    for tree in _trees(nodes, segments):
        part = _spread(tree)
        low = min(y for _, y in part.values())
        places.update({name: (x, y - low + top) for name, (x, y) in part.items()})
        top = max(places[name][1] for name in part) + _BETWEEN_PARTS_M
    return places


@dataclass(frozen=True)
class Limb:
    """A trunk, or a branch from where it leaves its parent to its end.

    Attributes:
        nodes: along it.
        level: 0 for a trunk; of a branch, one more than its parent's.
        parent: number of the limb that it leaves; None for a trunk.
    """

    nodes: tuple[str, ...]
    level: int
    parent: int | None


def limbs(nodes: Sequence[str], segments: Sequence[Segment]) -> tuple[Limb, ...]:
    """Return the trunk and the branches of each connected part, parents first.

    A segment that closes a ring belongs to none.
    """
    found: list[Limb] = []
    for tree in _trees(nodes, segments):
        trunk = _trunk(tree)
        if len(trunk) < 2:
            continue
        depth = _depths(tree, trunk[0])
        taken = set(trunk)
        number = len(found)
        found.append(Limb(tuple(trunk), 0, None))
        while number < len(found):
            parent = found[number]
            for node in parent.nodes:
                for other, _ in tree[node]:
                    if other in taken:
                        continue
                    path = _straight_on(tree, node, other, depth)
                    taken.update(path)
                    found.append(Limb((node, *path), parent.level + 1, number))
            number += 1
    return tuple(found)


def _straight_on(tree: _Tree, before: str, node: str, depth: dict[str, float]) -> list[str]:
    """Return the nodes of a branch from its first one on, along the part that reaches farthest."""
    path = [node]
    while True:
        following = [other for other, _ in tree[path[-1]] if other != before]
        if not following:
            return path
        before = path[-1]
        path.append(max(following, key=lambda name: depth[name]))


def _trees(nodes: Sequence[str], segments: Sequence[Segment]) -> list[_Tree]:
    """Return a spanning tree of each connected part, in the order of the nodes."""
    beside: dict[str, list[tuple[str, float]]] = defaultdict(list)
    for segment in segments:
        beside[segment.start].append((segment.end, segment.length_m))
        beside[segment.end].append((segment.start, segment.length_m))
    seen: set[str] = set()
    trees = []
    for root in nodes:
        if root in seen:
            continue
        tree: _Tree = {root: []}
        seen.add(root)
        queue = [root]
        for node in queue:
            for other, length in beside[node]:
                if other not in seen:
                    seen.add(other)
                    tree[node].append((other, length))
                    tree[other] = [(node, length)]
                    queue.append(other)
        trees.append(tree)
    return trees


def _spread(tree: _Tree) -> dict[str, Point]:
    trunk = _trunk(tree)
    places: dict[str, Point] = {trunk[0]: (0.0, 0.0)}
    for before, node in pairwise(trunk):
        places[node] = (places[before][0] + dict(tree[before])[node], 0.0)
    depth = _depths(tree, trunk[0])
    up = 1
    stack: list[tuple[str, str, float]] = []
    for node in trunk:
        for other, _ in tree[node]:
            if other not in places:
                stack.append((node, other, up * math.pi / 2))
                up = -up
    while stack:
        before, node, angle = stack.pop()
        length = dict(tree[before])[node]
        x, y = places[before]
        places[node] = (x + length * math.cos(angle), y + length * math.sin(angle))
        following = [other for other, _ in tree[node] if other not in places]
        following.sort(key=lambda name: -depth[name])
        turns = [0.0, math.pi / 2, -math.pi / 2, math.pi / 4, -math.pi / 4]
        for index, other in enumerate(following):
            stack.append((node, other, angle + turns[index % len(turns)]))
    return places


def _trunk(tree: _Tree) -> list[str]:
    """Return the longest path through a tree."""
    return _farthest(tree, _farthest(tree, next(iter(tree)))[-1])


def _farthest(tree: _Tree, start: str) -> list[str]:
    """Return the longest path from a node."""
    path: dict[str, tuple[float, str]] = {start: (0.0, "")}
    queue = [start]
    for node in queue:
        for other, length in tree[node]:
            if other not in path:
                path[other] = (path[node][0] + length, node)
                queue.append(other)
    node = max(queue, key=lambda name: path[name][0])
    nodes = [node]
    while node != start:
        node = path[node][1]
        nodes.append(node)
    return nodes[::-1]


def _depths(tree: _Tree, root: str) -> dict[str, float]:
    """Return how far the branches of each node reach, away from the root [m]."""
    order, before = [root], {root: ""}
    for node in order:
        for other, _ in tree[node]:
            if other not in before:
                before[other] = node
                order.append(other)
    depth = dict.fromkeys(order, 0.0)
    for node in reversed(order):
        for other, length in tree[node]:
            if before[other] == node:
                depth[node] = max(depth[node], depth[other] + length)
    return depth
