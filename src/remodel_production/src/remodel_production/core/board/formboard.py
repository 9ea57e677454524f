"""Lay out a harness on a formboard: true lengths of its segments, a trunk where it has none.

Of each connected part of the harness, the longest path through it is the trunk, which lies along x.
Every branch leaves its node at a right angle, up and down in turn; where it forks, its longer part
goes straight on. A segment that closes a ring of segments is not stretched out, but drawn straight
between its nodes.

If its connectors fall into two sides, so that each wire leads from one side to the other, they
stand in two rows that face each other, as a WireViz diagram draws them. The wires run straight from
connector to connector, through forks:

    ┌──┐ 1 ────┬────────┬──── 1 ┌──┐      Each connector stands as far along the trunk as the
    │X1│ 2 ────┼────────┤       │X2│      lengths of its wires ask for (`facing`). One that is
    └──┘ 3 ────┼── 1 ┌──┴┐      └──┘      nearer than its neighbours leaves room for the wires
               F1    │X3 │ F2             that pass it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from remodel_production.core.board.facing import Facing, FacingConnector, placed
from remodel_production.core.catalogue import Catalogue, FormboardRules
from remodel_production.core.production import Clip, Node, Order, Role, Segment, SegmentKind, Wire

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


TRUNK = "trunk"
_FORK = "fork"


def with_trunk(order: Order, catalogue: Catalogue) -> Order | None:
    """Return a harness between two rows of connectors, with routes and lengths of its wires.

    None: its design has devices, splices or segments, or its connectors have no two sides.
    """
    is_left = _sides(order)
    if is_left is None:
        return None
    rules = catalogue.formboard
    wired = [c for c in order.in_cabinet().components if c.name in is_left]
    depths = {c.name: catalogue.device_class(c).depth_m for c in wired}
    facing = placed(wired, is_left, order.wires, depths, rules)
    forks = _forks(facing, order.wires, rules)
    # The first row is on the right of the board: on the left as the robot sees it.
    nodes = [Node(name, (-stand.x, -stand.y, 0.0)) for name, stand in facing.stands.items()]
    nodes += [Node(name, (-x, 0.0, 0.0)) for name, x in forks.items()]
    passed = {wire.name: _passed(wire, facing, forks, rules) for wire in order.wires}
    at = {node.name: node.position[0] for node in nodes if node.position}
    legs = dict.fromkeys(leg for names in passed.values() for leg in pairwise(names))
    return replace(
        order,
        components=tuple(
            replace(c, node=c.name if c.name in is_left else "") for c in order.components
        ),
        wires=tuple(
            replace(
                wire,
                route=tuple(map(_leg, pairwise(passed[wire.name]))),
                length_m=wire.length_m or round(facing.distance(wire) + rules.wire_slack, 3),
            )
            for wire in order.wires
        ),
        nodes=tuple(nodes),
        segments=tuple(
            Segment(_leg(leg), *leg, round(at[leg[0]] - at[leg[1]], 6), SegmentKind.STRAIGHT)
            for leg in legs
        ),
        clips=tuple(
            Clip(f"F{number}", _FORK, node=name) for number, name in enumerate(forks, start=1)
        ),
    )


def _leg(ends: tuple[str, str]) -> str:
    return f"{ends[0]}..{ends[1]}"


def _sides(order: Order) -> dict[str, bool] | None:
    """Return whether each wired connector is on the left; None if there are no two sides."""
    if order.segments or any(c.role is not Role.CONNECTOR for c in order.components):
        return None
    beside: dict[str, list[str]] = defaultdict(list)
    for wire in order.wires:
        beside[wire.a.component].append(wire.b.component)
        beside[wire.b.component].append(wire.a.component)
    is_left: dict[str, bool] = {}
    for component in order.components:
        if component.name in is_left or component.name not in beside:
            continue
        is_left[component.name] = True
        queue = [component.name]
        for name in queue:
            for other in beside[name]:
                if other not in is_left:
                    is_left[other] = not is_left[name]
                    queue.append(other)
    if any(is_left[wire.a.component] == is_left[wire.b.component] for wire in order.wires):
        return None
    return is_left


def _forks(facing: Facing, wires: Sequence[Wire], rules: FormboardRules) -> dict[str, float]:
    """Return where forks stand along the trunk, by the names of their nodes [m]."""
    xs = [stand.x for stand in facing.stands.values()]
    span = max(xs) - min(xs)
    count = max(1, round(span / rules.fork_spacing) - 1)
    places = [min(xs) + span * number / (count + 1) for number in range(1, count + 1)]
    free = [x for x in places if not _is_taken(x, facing, wires, rules)]
    return {f"{TRUNK}/{number}": round(x, 6) for number, x in enumerate(free, start=1)}


def _is_taken(x: float, facing: Facing, wires: Sequence[Wire], rules: FormboardRules) -> bool:
    """Return whether a fork for the wires that pass there would stand in a connector's place."""
    asides = [facing.aside(wire, x) for wire in wires if _passes(facing.ends(wire), x, rules)]
    if not asides:
        return True
    low, high = min(asides) - rules.fork.play / 2, max(asides) + rules.fork.play / 2
    return any(
        stand.back - rules.fork_before < x < stand.front + rules.fork_before
        and low < stand.y + stand.width / 2
        and stand.y - stand.width / 2 < high
        for stand in facing.stands.values()
    )


def _passes(ends: tuple[FacingConnector, FacingConnector], x: float, rules: FormboardRules) -> bool:
    left, right = ends
    return left.x + rules.fork_before <= x <= right.x - rules.fork_before


def _passed(
    wire: Wire, facing: Facing, forks: Mapping[str, float], rules: FormboardRules
) -> tuple[str, ...]:
    """Return the nodes that a wire passes, from left to right."""
    left, right = facing.ends(wire)
    between = [name for name, x in forks.items() if _passes((left, right), x, rules)]
    return (left.name, *between, right.name)
