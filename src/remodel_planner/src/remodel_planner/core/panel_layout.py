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
    """What the cell can reach and handle; lengths in [m].

    The numbers are the middle of what remodel_sim allows (its README, layout rules).
    """

    rows: int = 3
    row_pitch: float = 0.16
    width: float = 0.60
    component_depth: float = 0.05
    component_height: float = 0.042
    terminal_pitch: float = 0.016
    component_margin: float = 0.012
    component_gap: float = 0.006
    mouth_height: float = 0.022
    marker_size: float = 0.026
    bore_clearance: float = 0.0008
    bore_beyond_ferrule: float = 0.002
    chamfer: float = 0.0015
    retention_force: float = 40.0  # [N]
    # A wire is longer than the way along the channel by the first, never shorter than the second.
    # Its loose end is in reach only up to `reach_y` along the channel.
    wire_slack: float = 0.26
    shortest_wire: float = 0.40
    reach_y: float = 0.52


@dataclass(frozen=True)
class PlacedTerminal:
    """A terminal in its component's frame: mouth [m], direction of insertion [rad], bore [m]."""

    name: str
    x: float
    y: float
    z: float
    insertion_yaw: float
    bore: float
    depth: float


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
    """A wire cut to length.

    Attributes:
        first: the terminal that its first end is placed in, the wire's `a` or `b`: the one from
            which the loose end stays in reach.
        second: the other.
        length: [m] from tip to tip.
        channel: in which it lies.
        first_y: [m] of the first terminal's mouth, panel frame.
        second_y: [m] of the second's.
    """

    wire: Wire
    type: WireType
    first: TerminalRef
    second: TerminalRef
    length: float
    channel: str
    first_y: float
    second_y: float


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
    types = {
        end: catalogue.wire_type(wire.section_mm2)
        for wire in order.wires
        for end in (wire.a, wire.b)
    }
    components = []
    for row, members in sorted(rows.items()):
        components += _place_row(row, len(rows), members, types, len(components), rules)
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
    types: dict[TerminalRef, WireType],
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
            terminal for side in Side for terminal in _place_side(component, side, types, rules)
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
    component: Component, side: Side, types: dict[TerminalRef, WireType], rules: PanelRules
) -> list[PlacedTerminal]:
    """Return the terminals of one side, from left (+y) to right as seen by the robot."""
    terminals = [terminal for terminal in component.terminals if terminal.side is side]
    sign = 1 if side is Side.TOP else -1
    placed = []
    for index, terminal in enumerate(terminals):
        wire_type = types[TerminalRef(component.name, terminal.name)]
        placed.append(
            PlacedTerminal(
                terminal.name,
                sign * rules.component_depth / 2,
                ((len(terminals) - 1) / 2 - index) * rules.terminal_pitch,
                rules.mouth_height,
                math.pi if side is Side.TOP else 0.0,
                round(wire_type.diameter_m + rules.bore_clearance, 6),
                round(wire_type.ferrule_m + rules.bore_beyond_ferrule, 6),
            )
        )
    return placed


def _cut(
    wire: Wire,
    components: list[PlacedComponent],
    channels: tuple[PlacedChannel, ...],
    catalogue: Catalogue,
    rules: PanelRules,
) -> CutWire:
    (ax, ay), (bx, by) = (_mouth(end, components) for end in (wire.a, wire.b))
    channel = min(channels, key=lambda channel: abs(channel.x - ax) + abs(channel.x - bx))
    length = max(rules.shortest_wire, abs(ay - by) + rules.wire_slack)
    length = math.ceil(length * 100) / 100
    ends = ((wire.a, ay), (wire.b, by))
    (first, first_y), (second, second_y) = min(
        (ends, ends[::-1]), key=lambda pair: _loose_end(pair[0][1], pair[1][1], length)
    )
    if _loose_end(first_y, second_y, length) > rules.reach_y:
        raise LayoutError(
            f"wire {wire.name} ({wire.a} to {wire.b}): with one end placed, its {length:.2f} m "
            f"reach beyond {rules.reach_y:.2f} m from the panel's middle: choose fewer wires"
        )
    wire_type = catalogue.wire_type(wire.section_mm2)
    return CutWire(wire, wire_type, first, second, length, channel.name, first_y, second_y)


def _loose_end(first_y: float, second_y: float, length: float) -> float:
    """Return how far from the middle [m] a wire's loose end lies once the first end is placed."""
    return length + first_y * (1 if second_y >= first_y else -1)


def _mouth(end: TerminalRef, components: list[PlacedComponent]) -> tuple[float, float]:
    """Return the mouth's x, y [m] in the panel frame."""
    for placed in components:
        if placed.component.name == end.component:
            for terminal in placed.terminals:
                if terminal.name == end.terminal:
                    return placed.x + terminal.x, placed.y + terminal.y
    raise LayoutError(f"the order has a wire to {end}, and no such terminal")
