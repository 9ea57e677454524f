"""Place an order's components on a panel, and cut its wires to length.

Components stand in rows along y, with a channel between two rows (panel_rows.py). Along y they
stand such that every wire runs some distance along its channel: rows stand to the left and to the
right in turn, and the places are the least solution of the constraints on their differences.
Up is +x, away from the robot. All of it is deterministic.

Panel frame: origin at the centre of the plate's surface, x away from the robot, y to its left,
z up.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from remodel_production.core.catalogue import Catalogue, WireType
from remodel_production.core.panel.difference_constraints import AtLeast, least_solution
from remodel_production.core.panel.panel_rows import Row, is_left, ordered_rows
from remodel_production.core.production import Component, Order, Side, TerminalRef, Wire
from remodel_production.errors import LayoutError


@dataclass(frozen=True)
class PanelRules:
    """What the cell can reach and handle; lengths in [m].

    The numbers are the middle of what remodel_sim allows (its README, layout rules).
    """

    rows: int = 3
    row_pitch: float = 0.16
    plate_width: float = 1.00  # loose ends lie on it too, up to reach_y
    row_width: float = 0.60
    component_depth: float = 0.05
    component_height: float = 0.042
    terminal_pitch: float = 0.016
    component_margin: float = 0.010
    component_gap: float = 0.004
    opening_height: float = 0.022
    opening_y: float = 0.29
    marker_size: float = 0.022
    label_margin: float = 0.004
    bore_clearance: float = 0.0008
    bore_beyond_ferrule: float = 0.002
    chamfer: float = 0.0015
    retention_force: float = 40.0  # [N]
    # A wire is longer than its distance along its channel by `wire_slack`. Its loose end is in
    # reach only up to `reach_y` along the channel. The distance is long enough for a wire that
    # bends easily; where there is no room for that, each shorter one is tried in turn.
    wire_slack: float = 0.30
    shortest_wire: float = 0.40
    longest_wire: float = 0.75
    reach_y: float = 0.52
    distances_min: tuple[float, ...] = (0.16, 0.12, 0.08, 0.04, 0.0)


@dataclass(frozen=True)
class PlacedTerminal:
    """A terminal in its component's frame: opening [m], direction of insertion [rad], width [m]."""

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
        first_y: [m] of the first terminal's opening, panel frame.
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
    rows = ordered_rows(order, rules.rows)
    types = {
        end: catalogue.wire_type(wire.section_mm2)
        for wire in order.wires
        for end in (wire.a, wire.b)
    }
    terminals = {
        component.name: _terminals(component, types, rules) for row in rows for component in row
    }
    y = _along_rows(order, rows, terminals, rules)
    components = tuple(
        PlacedComponent(
            component,
            marker_id,
            _row_x(row, len(rows), rules),
            y[component.name],
            depth=rules.component_depth,
            width=_width(component, rules),
            height=rules.component_height,
            terminals=terminals[component.name],
        )
        for marker_id, (row, component) in enumerate(
            (row, component) for row, members in enumerate(rows) for component in members
        )
    )
    channels = tuple(
        PlacedChannel(
            chr(ord("A") + row),
            _row_x(row, len(rows), rules) - rules.row_pitch / 2,
            rules.row_pitch - rules.component_depth,
            -rules.plate_width / 2,
            y_max=rules.plate_width / 2,
        )
        for row in range(max(1, len(rows) - 1))
    )
    wires = tuple(_cut(wire, components, channels, catalogue, rules=rules) for wire in order.wires)
    depth = (max(1, len(rows) - 1)) * rules.row_pitch + 2 * rules.component_depth
    return PanelLayout(
        order.name, depth, rules.plate_width, components, channels=channels, wires=wires
    )


def _row_x(row: int, count: int, rules: PanelRules) -> float:
    return ((max(count, 2) - 1) / 2 - row) * rules.row_pitch


def _width(component: Component, rules: PanelRules) -> float:
    most = max(sum(t.side is side for t in component.terminals) for side in Side)
    needed = (most - 1) * rules.terminal_pitch + 2 * rules.component_margin
    return max(needed, rules.marker_size + 2 * rules.label_margin)


def _terminals(
    component: Component, types: dict[TerminalRef, WireType], rules: PanelRules
) -> tuple[PlacedTerminal, ...]:
    """Return a component's terminals, each side from left (+y) to right as seen by the robot."""
    placed = []
    for side in Side:
        terminals = [terminal for terminal in component.terminals if terminal.side is side]
        for index, terminal in enumerate(terminals):
            wire_type = types[TerminalRef(component.name, terminal.name)]
            placed.append(
                PlacedTerminal(
                    terminal.name,
                    (1 if side is Side.TOP else -1) * rules.component_depth / 2,
                    ((len(terminals) - 1) / 2 - index) * rules.terminal_pitch,
                    rules.opening_height,
                    insertion_yaw=math.pi if side is Side.TOP else 0.0,
                    bore=round(wire_type.diameter_m + rules.bore_clearance, 6),
                    depth=round(wire_type.ferrule_m + rules.bore_beyond_ferrule, 6),
                )
            )
    return tuple(placed)


def _along_rows(
    order: Order,
    rows: tuple[Row, ...],
    terminals: dict[str, tuple[PlacedTerminal, ...]],
    rules: PanelRules,
) -> dict[str, float]:
    """Return the y [m] of each component's centre."""
    for index, row in enumerate(rows):
        needed = sum(_width(c, rules) for c in row) + rules.component_gap * (len(row) - 1)
        if needed > rules.row_width:
            raise LayoutError(
                f"row {index + 1} needs {needed:.2f} m for {', '.join(c.name for c in row)}; the "
                f"panel has {rules.row_width:.2f} m for it: choose fewer wires"
            )
    least, most = {}, {}
    for component in (component for row in rows for component in row):
        offsets = [terminal.y for terminal in terminals[component.name]]
        edge = (rules.row_width - _width(component, rules)) / 2
        least[component.name] = max(-edge, -rules.opening_y - min(offsets))
        most[component.name] = min(edge, rules.opening_y - max(offsets))
    in_rows = [*_beside_each_other(rows, rules)]
    for distance_min in rules.distances_min:
        distances = _distances(order, rows, terminals, distance_min, rules=rules)
        y = least_solution(least, [*in_rows, *distances])
        if y is not None and all(y[name] <= most[name] + 1e-9 for name in y):
            to_the_middle = min(most[name] - y[name] for name in y) / 2
            return {name: value + to_the_middle for name, value in y.items()}
    raise LayoutError(
        f"order {order.name}: no places in rows of {rules.row_width:.2f} m leave every wire a "
        f"distance of at most {rules.longest_wire - rules.wire_slack:.2f} m: choose fewer wires"
    )


def _beside_each_other(rows: Iterable[Row], rules: PanelRules) -> Iterator[AtLeast]:
    for row in rows:
        for left, right in pairwise(row):
            pitch = (_width(left, rules) + _width(right, rules)) / 2 + rules.component_gap
            yield AtLeast(left.name, right.name, pitch)


def _distances(
    order: Order,
    rows: tuple[Row, ...],
    terminals: dict[str, tuple[PlacedTerminal, ...]],
    distance_min: float,
    rules: PanelRules,
) -> Iterator[AtLeast]:
    """Yield the least and the greatest distance of each wire's ends along its channel."""
    rank = {
        component.name: (not is_left(index), place)
        for index, row in enumerate(rows)
        for place, component in enumerate(row)
    }
    offset = {
        TerminalRef(name, terminal.name): terminal.y
        for name, placed in terminals.items()
        for terminal in placed
    }
    distance_max = rules.longest_wire - rules.wire_slack
    for wire in order.wires:
        left, right = sorted((wire.a, wire.b), key=lambda end: rank[end.component])
        already = offset[left] - offset[right]
        yield AtLeast(left.component, right.component, distance_min - already)
        yield AtLeast(right.component, left.component, already - distance_max)


def _cut(
    wire: Wire,
    components: tuple[PlacedComponent, ...],
    channels: tuple[PlacedChannel, ...],
    catalogue: Catalogue,
    rules: PanelRules,
) -> CutWire:
    (ax, ay), (bx, by) = (_opening(end, components) for end in (wire.a, wire.b))
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
    return CutWire(
        wire,
        wire_type,
        first,
        second,
        length=length,
        channel=channel.name,
        first_y=first_y,
        second_y=second_y,
    )


def _loose_end(first_y: float, second_y: float, length: float) -> float:
    """Return how far from the middle [m] a wire's loose end lies once the first end is placed."""
    return length + first_y * (1 if second_y >= first_y else -1)


def _opening(end: TerminalRef, components: tuple[PlacedComponent, ...]) -> tuple[float, float]:
    """Return the opening's x, y [m] in the panel frame."""
    for placed in components:
        if placed.component.name == end.component:
            for terminal in placed.terminals:
                if terminal.name == end.terminal:
                    return placed.x + terminal.x, placed.y + terminal.y
    raise LayoutError(f"the order has a wire to {end}, and no such terminal")
