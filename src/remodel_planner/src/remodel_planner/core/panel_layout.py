"""Place an order's components on a panel, and cut its wires to length.

Components stand in rows along y, at most three; between two rows lies a channel, into which the
bottom terminals of the upper row and the top terminals of the lower row open. Up is +x, away from
the robot. A wire can be placed if both its ends open into the same channel, so

    bottom of u to top of v        v stands one row below u
    top to top, bottom to bottom   u and v stand in the same row

which fixes the row of every component relative to those it is wired to. Within a row, components
stand in the order's order, centred. All of it is deterministic.

Panel frame: origin at the centre of the plate's surface, x away from the robot, y to its left,
z up.
"""

from __future__ import annotations

import math
from collections import defaultdict, deque
from dataclasses import dataclass

from remodel_planner.core.catalogue import Catalogue, WireType
from remodel_planner.core.production import Component, Order, Side, TerminalRef, Wire
from remodel_planner.errors import LayoutError


@dataclass(frozen=True)
class PanelRules:
    """What the cell can reach and handle; lengths in [m]."""

    rows: int = 3
    row_pitch: float = 0.19
    width: float = 0.60
    component_depth: float = 0.05
    component_height: float = 0.042
    terminal_pitch: float = 0.018
    component_margin: float = 0.012
    component_gap: float = 0.006
    mouth_height: float = 0.022
    marker_size: float = 0.026
    bore_clearance: float = 0.0010
    bore_depth: float = 0.014
    chamfer: float = 0.002
    retention_force: float = 20.0  # [N] the smallest pull that IEC 60999-1 asks of 0.75 mm2
    wire_slack: float = 0.16
    shortest_wire: float = 0.30


@dataclass(frozen=True)
class PlacedTerminal:
    """A terminal in its component's frame: mouth [m] and direction of insertion [rad]."""

    name: str
    x: float
    y: float
    z: float
    insertion_yaw: float
    bore: float


@dataclass(frozen=True)
class PlacedComponent:
    """A component on the panel: centre of its base [m], extent [m], terminals."""

    component: Component
    marker_id: int
    x: float
    y: float
    depth: float
    width: float
    height: float
    terminals: tuple[PlacedTerminal, ...]


@dataclass(frozen=True)
class PlacedChannel:
    """The lane between two rows: its centre line at x, [m]."""

    name: str
    x: float
    width: float
    y_min: float
    y_max: float


@dataclass(frozen=True)
class CutWire:
    """A wire with its length [m], the channel it lies in, and the place of its end b."""

    wire: Wire
    type: WireType
    length: float
    channel: str
    b_mouth: tuple[float, float]
    b_insertion_yaw: float


@dataclass(frozen=True)
class PanelLayout:
    """A panel with everything on it."""

    name: str
    depth: float
    width: float
    components: tuple[PlacedComponent, ...]
    channels: tuple[PlacedChannel, ...]
    wires: tuple[CutWire, ...]


def lay_out(order: Order, catalogue: Catalogue, rules: PanelRules) -> PanelLayout:
    """Return the panel for an order.

    Raises:
        LayoutError: if wires contradict each other on the rows, or rows are too many or too wide.
        CatalogueError: if a wire's section is not in the catalogue.
    """
    rows = _rows(order, rules)
    diameters = {
        end: catalogue.wire_type(wire.section_mm2).diameter_m
        for wire in order.wires
        for end in (wire.a, wire.b)
    }
    components = []
    for row, members in sorted(rows.items()):
        components += _place_row(row, len(rows), members, diameters, len(components), rules)
    channels = tuple(
        PlacedChannel(
            chr(ord("A") + row),
            _row_x(row, len(rows), rules) - rules.row_pitch / 2,
            rules.row_pitch - rules.component_depth,
            -rules.width / 2,
            rules.width / 2,
        )
        for row in range(max(1, len(rows) - 1))
    )
    wires = tuple(_cut(wire, components, channels, catalogue, rules) for wire in order.wires)
    depth = (max(1, len(rows) - 1)) * rules.row_pitch + 2 * rules.component_depth
    return PanelLayout(order.name, depth, rules.width, tuple(components), channels, wires)


def _rows(order: Order, rules: PanelRules) -> dict[int, list[Component]]:
    """Return the components of each row, 0 is the upmost."""
    sides = {
        TerminalRef(component.name, terminal.name): terminal.side
        for component in order.components
        for terminal in component.terminals
    }
    steps: dict[str, list[tuple[str, int, Wire]]] = defaultdict(list)
    for wire in order.wires:
        step = (sides[wire.a] is Side.BOTTOM) - (sides[wire.b] is Side.BOTTOM)
        steps[wire.a.component].append((wire.b.component, step, wire))
        steps[wire.b.component].append((wire.a.component, -step, wire))
    row: dict[str, int] = {}
    for component in order.components:
        if component.name not in row:
            group = _group_rows(component.name, steps)
            top = min(group.values())
            row.update({name: value - top for name, value in group.items()})
    count = max(row.values()) + 1
    if count > rules.rows:
        raise LayoutError(
            f"order {order.name}: its wires need {count} rows of components one below the other; "
            f"the panel has {rules.rows}: choose fewer wires"
        )
    rows: dict[int, list[Component]] = {index: [] for index in range(count)}
    for component in order.components:
        rows[row[component.name]].append(component)
    return rows


def _group_rows(start: str, steps: dict[str, list[tuple[str, int, Wire]]]) -> dict[str, int]:
    """Return the rows, relative to the first, of all components wired to each other."""
    row = {start: 0}
    queue = deque([start])
    while queue:
        name = queue.popleft()
        for other, step, wire in steps[name]:
            expected = row[name] + step
            if other not in row:
                row[other] = expected
                queue.append(other)
            elif row[other] != expected:
                raise LayoutError(
                    f"wire {wire.name} ({wire.a} to {wire.b}, {wire.source}): the other wires put "
                    f"{other} {row[other] - row[name]} row(s) below {name}, where its two ends do "
                    "not open into one channel; this cell cannot route it around a row"
                )
    return row


def _row_x(row: int, count: int, rules: PanelRules) -> float:
    return ((max(count, 2) - 1) / 2 - row) * rules.row_pitch


def _place_row(
    row: int,
    count: int,
    members: list[Component],
    diameters: dict[TerminalRef, float],
    first_marker: int,
    rules: PanelRules,
) -> list[PlacedComponent]:
    widths = [_width(component, rules) for component in members]
    total = sum(widths) + rules.component_gap * (len(widths) - 1)
    if total > rules.width:
        raise LayoutError(
            f"row {row + 1} needs {total:.2f} m for {', '.join(c.name for c in members)}; the "
            f"panel is {rules.width:.2f} m wide: choose fewer wires"
        )
    placed = []
    y = total / 2
    for offset, (component, width) in enumerate(zip(members, widths, strict=True)):
        terminals = tuple(
            terminal for side in Side for terminal in _place_side(component, side, diameters, rules)
        )
        placed.append(
            PlacedComponent(
                component,
                first_marker + offset,
                _row_x(row, count, rules),
                y - width / 2,
                rules.component_depth,
                width,
                rules.component_height,
                terminals,
            )
        )
        y -= width + rules.component_gap
    return placed


def _width(component: Component, rules: PanelRules) -> float:
    most = max(sum(t.side is side for t in component.terminals) for side in Side)
    needed = (most - 1) * rules.terminal_pitch + 2 * rules.component_margin
    return max(needed, rules.marker_size + 0.010)  # the label with a white border of 5 mm


def _place_side(
    component: Component, side: Side, diameters: dict[TerminalRef, float], rules: PanelRules
) -> list[PlacedTerminal]:
    """Return the terminals of one side, from left (+y) to right as seen by the robot."""
    terminals = [terminal for terminal in component.terminals if terminal.side is side]
    sign = 1 if side is Side.TOP else -1
    return [
        PlacedTerminal(
            terminal.name,
            sign * rules.component_depth / 2,
            ((len(terminals) - 1) / 2 - index) * rules.terminal_pitch,
            rules.mouth_height,
            math.pi if side is Side.TOP else 0.0,
            round(diameters[TerminalRef(component.name, terminal.name)] + rules.bore_clearance, 6),
        )
        for index, terminal in enumerate(terminals)
    ]


def _cut(
    wire: Wire,
    components: list[PlacedComponent],
    channels: tuple[PlacedChannel, ...],
    catalogue: Catalogue,
    rules: PanelRules,
) -> CutWire:
    (ax, ay, _), (bx, by, b_yaw) = (_mouth(end, components) for end in (wire.a, wire.b))
    channel = min(channels, key=lambda channel: abs(channel.x - ax) + abs(channel.x - bx))
    straight = abs(ay - by) + abs(channel.x - ax) + abs(channel.x - bx)
    length = max(rules.shortest_wire, straight + rules.wire_slack)
    return CutWire(
        wire,
        catalogue.wire_type(wire.section_mm2),
        math.ceil(length * 100) / 100,
        channel.name,
        (bx, by),
        b_yaw,
    )


def _mouth(end: TerminalRef, components: list[PlacedComponent]) -> tuple[float, float, float]:
    """Return the mouth's x, y [m] and direction of insertion [rad] in the panel frame."""
    for placed in components:
        if placed.component.name == end.component:
            for terminal in placed.terminals:
                if terminal.name == end.terminal:
                    return placed.x + terminal.x, placed.y + terminal.y, terminal.insertion_yaw
    raise LayoutError(f"the order has a wire to {end}, and no such terminal")
