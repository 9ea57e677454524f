"""Give a harness of connectors alone the trunk that its design, such as WireViz, does not have.

If its connectors fall into two sides, so that each wire leads from one side to the other, they
stand in two rows that face each other, as a WireViz diagram draws them. The wires run straight from
connector to connector, through forks:

    ┌──┐ 1 ────┬────────┬──── 1 ┌──┐      Each connector stands as far along the trunk as the
    │X1│ 2 ────┼────────┤       │X2│      lengths of its wires ask for (`facing`). One that is
    └──┘ 3 ────┼── 1 ┌──┴┐      └──┘      nearer than its neighbours leaves room for the wires
               F1    │X3 │ F2             that pass it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from remodel_production.core.board.facing import Facing, Stand, placed
from remodel_production.core.catalogue import Catalogue, FormboardRules
from remodel_production.core.production import (
    Clip,
    Node,
    Order,
    Role,
    Segment,
    SegmentKind,
    Wire,
)

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
    depths = {c.name: catalogue.device_class(c.role, c.part_number, c.kind).depth_m for c in wired}
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


def _passes(ends: tuple[Stand, Stand], x: float, rules: FormboardRules) -> bool:
    left, right = ends
    return left.x + rules.fork_before <= x <= right.x - rules.fork_before


def _passed(
    wire: Wire, facing: Facing, forks: Mapping[str, float], rules: FormboardRules
) -> tuple[str, ...]:
    """Return the nodes that a wire passes, from left to right."""
    left, right = facing.ends(wire)
    between = [name for name, x in forks.items() if _passes((left, right), x, rules)]
    return (left.name, *between, right.name)
