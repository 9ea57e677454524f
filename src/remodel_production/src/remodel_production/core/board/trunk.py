"""Give a harness of connectors alone the trunk that its design, such as WireViz, does not have.

If its connectors fall into two sides, so that each wire leads from one side to the other, they
stand in two rows that face each other, as a WireViz diagram draws them. The wires run straight from
row to row, through forks.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace

from remodel_production.core.board.connector_rows import row_of
from remodel_production.core.catalogue import Catalogue, FormboardRules
from remodel_production.core.production import (
    Clip,
    Component,
    Node,
    Order,
    Role,
    Segment,
    Wire,
)

LEFT, RIGHT, TRUNK = "left", "right", "trunk"
_FORK = "fork"


def with_trunk(order: Order, catalogue: Catalogue) -> Order | None:
    """Return a harness between two rows of connectors, with routes and lengths of its wires.

    None: its design has devices, splices or segments, or its connectors have no two sides.
    """
    side = _sides(order)
    if side is None:
        return None
    rules = catalogue.formboard
    rows = [
        row_of(_wired(order, side, name), rules.cavity_pitch, rules.connector_gap)
        for name in (LEFT, RIGHT)
    ]
    cavities = {ref: along for row in rows for ref, along in row.cavities.items()}
    # The rows face each other: along both, the same is on opposite sides of the trunk.
    across = {wire.name: cavities[wire.a] + cavities[wire.b] for wire in order.wires}
    span = _span(order, across, rules)
    count = max(1, round(span / rules.fork_spacing) - 1)
    forks = tuple(
        Clip(f"F{index}", _FORK, segment=TRUNK, along=round(index / (count + 1), 6))
        for index in range(1, count + 1)
    )
    return replace(
        order,
        components=tuple(replace(c, node=side.get(c.name, "")) for c in order.components),
        wires=tuple(
            _routed(wire, math.hypot(span, across[wire.name]), rules) for wire in order.wires
        ),
        nodes=(Node(LEFT, None), Node(RIGHT, None)),
        segments=(Segment(TRUNK, LEFT, RIGHT, span),),
        clips=forks,
    )


def _sides(order: Order) -> dict[str, str] | None:
    """Return the side of each connector that is wired; None if there are no two sides."""
    if order.segments or any(c.role is not Role.CONNECTOR for c in order.components):
        return None
    beside: dict[str, list[str]] = defaultdict(list)
    for wire in order.wires:
        beside[wire.a.component].append(wire.b.component)
        beside[wire.b.component].append(wire.a.component)
    side: dict[str, str] = {}
    for component in order.components:
        if component.name in side or component.name not in beside:
            continue
        side[component.name] = LEFT
        queue = [component.name]
        for name in queue:
            for other in beside[name]:
                if other not in side:
                    side[other] = RIGHT if side[name] == LEFT else LEFT
                    queue.append(other)
    if any(side[wire.a.component] == side[wire.b.component] for wire in order.wires):
        return None
    return side


def _wired(order: Order, side: dict[str, str], name: str) -> list[Component]:
    return [c for c in order.in_cabinet().components if side.get(c.name) == name]


def _span(order: Order, across: dict[str, float], rules: FormboardRules) -> float:
    """Return the distance between the rows [m]: that of the shortest wire, drawn straight."""
    spans = [
        math.sqrt(max(0.0, (wire.length_m - rules.wire_slack) ** 2 - across[wire.name] ** 2))
        for wire in order.wires
        if wire.length_m is not None
    ]
    return round(max(min(spans, default=rules.trunk), rules.fork_spacing), 6)


def _routed(wire: Wire, straight: float, rules: FormboardRules) -> Wire:
    length = wire.length_m or round(straight + rules.wire_slack, 3)
    return replace(wire, route=(TRUNK,), length_m=length)
