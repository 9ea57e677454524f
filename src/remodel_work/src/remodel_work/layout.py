"""The layout rules of a panel, and the check against them; README.md explains them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from itertools import pairwise

from remodel_states.core.cell import CellLimits, footprint, overlaps, within
from remodel_states.core.wires import WIRE_RGB, is_colour
from remodel_work.board_rules import board_problems
from remodel_work.geometry import Pose, wrap_angle
from remodel_work.panel import (
    Channel,
    Component,
    Connector,
    Duct,
    Named,
    Panel,
    PanelClip,
    PanelTerminal,
    PanelWire,
    Rail,
    WireEnd,
    unit_x,
)
from remodel_work.robot.arm import Kinematics, ToolPose

# Tool centre to tip when a wire is held for insertion: short enough not to buckle or sag, long
# enough for the fingers.
GRASP_DISTANCE_M = 0.045
# The tip waits so far in front of the opening before it is pushed in.
STANDOFF_M = 0.008

COMPONENT_HEIGHT_M = (0.030, 0.045)  # the hand clears it, and covers the openings
OPENING_HEIGHT_M = (0.020, 0.026)  # above the plate
TERMINAL_MAX_Y_M = 0.30
CHANNEL_WIDTH_M = (0.100, 0.150)
OPENING_OFF_EDGE_M = 0.003  # between an opening and its channel's edge
OPENING_CLEARANCE_M = (0.0006, 0.0020)  # its width minus the wire diameter
CHAMFER_M = (0.0010, 0.0025)
DEPTH_M = (0.010, 0.020)
DEPTH_BEYOND_FERRULE_M = 0.001  # an inserted ferrule is hidden: only loose ends show its colour
OPENING_GAP_M = 0.0005  # between neighbouring openings
RETENTION_N = (1.0, 200.0)
MARKER_MIN_M = 0.011
MARKER_MARGIN = 1 / 6  # of the label's side, all around
FERRULE_M = (0.010, 0.016)
# A wire needs so much more than the distance along y between its terminals, and may have so much
# more.
LENGTH_BEYOND_M = (0.22, 0.38)
# The same for a wire whose terminals open into different channels: it crosses the row between them.
CROSSING_BEYOND_M = (0.42, 0.55)
STIFFNESS_NM2 = (2e-4, 1.5e-2)
DENSITY_KG_M = (0.005, 0.20)
TORSION_NM2 = (1e-4, 1.5e-2)
FRICTION = (0.1, 1.5)
REST_CURVATURE_1_M = (0.0, 2.0)
YIELD_CURVATURE_1_M = (2.0, 1000.0)  # less, and a wire folds where the hand turns it
HARDENING = (0.0, 0.95)
WAYS = (2, 3)  # more are wider than the open hand
PIN_DIAMETER_M = (0.001, 0.003)
PIN_LENGTH_M = (0.006, 0.012)
BODY_LENGTH_M = (0.021, 0.030)  # the pads hold it behind its face
BODY_WIDTH_M = (0.006, 0.018)  # the open hand goes over it
MATING_N = (1.0, 30.0)
# A header holds more than the pull that tests its latch; its openings are deeper than the pins.
LATCH_N = (15.0, 200.0)
DEPTH_BEYOND_PINS_M = 0.0005
CLIP_FLOOR_M = 0.002  # under the wire
CLIP_MAX_HEIGHT_M = 0.030
CLIP_LENGTH_M = (0.004, 0.030)
CLIP_RETENTION_N = (2.0, 20.0)
DUCT_WIDTH_M = (0.010, 0.150)
DUCT_HEIGHT_M = (0.005, 0.045)  # any hand clears them
# Fingers longer than this by a duct's height clear it: their tips reach below the openings.
DUCT_BELOW_HAND_M = 0.035
FINGER_MIN_M = 0.001  # of a duct's comb
RAIL_WIDTH_M = (0.010, 0.100)
RAIL_HEIGHT_M = (0.001, 0.016)  # wires lie over them, below the openings
# Feeding: the far tip lies within this, and after end a is in, end b is picked within reach.
FEED_LIMIT_Y_M = 0.45
FEED_REACH_M = 0.52


def find_problems(
    panel: Panel,
    arms: Sequence[Kinematics],
    takes: CellLimits,
    *,
    has_magazine: bool = False,
    has_labels: bool = True,
) -> tuple[str, ...]:
    """Return every violation of the rules by a panel, one sentence each.

    None: it can be built by a cell that takes so much. Each terminal must be within reach of one of
    the arms. Wires are fed into channels; a panel without any needs a cell with a magazine. Labels
    have rules where components carry them.
    """
    unreal = tuple(_not_finite(panel, "panel"))
    if unreal:
        return unreal
    return (
        *takes.about_board(panel.size[:2], len(panel.components)),
        *_plate(panel, has_magazine=has_magazine),
        *_names(panel),
        *(_labels(panel, takes.devices) if has_labels else ()),
        *(p for channel in panel.channels for p in _channel(channel)),
        *(p for component in panel.components for p in _component(component, panel, arms)),
        *(p for clip in panel.clips for p in _clip(clip, panel, takes)),
        *(p for duct in panel.ducts for p in _duct(duct, panel, arms)),
        *(p for rail in panel.rails for p in _rail(rail, panel)),
        *_overlaps(panel),
        *(p for wire in panel.wires for p in _wire(wire, panel, takes)),
        *_sharing(panel),
        *board_problems(panel, arms, takes, STANDOFF_M),
    )


def _not_finite(value: object, path: str) -> Iterator[str]:
    if isinstance(value, float) and not math.isfinite(value):
        yield f"{path} is {value}; it must be a finite number"
    elif isinstance(value, tuple):
        for i, item in enumerate(value):
            yield from _not_finite(item, f"{path}[{getattr(item, 'id', i)}]")
    elif is_dataclass(value):
        for field in fields(value):
            yield from _not_finite(getattr(value, field.name), f"{path}.{field.name}")


def _plate(panel: Panel, *, has_magazine: bool) -> Iterator[str]:
    yield from within("the plate's thickness", panel.size[2], (0.001, 0.02))
    if not panel.channels and not has_magazine:
        yield "the panel has no channel; wires are fed into one: a cell with a magazine needs none"


def _names(panel: Panel) -> Iterator[str]:
    groups: list[tuple[str, Sequence[Named]]] = [
        ("components", panel.components),
        ("channels", panel.channels),
        ("wires", panel.wires),
        ("clips", panel.clips),
        ("ducts", panel.ducts),
        ("rails", panel.rails),
        ("connectors", [c for wire in panel.wires for c in wire.connectors]),
    ]
    groups += [(f"terminals of {c.id!r}", c.terminals) for c in panel.components]
    for noun, items in groups:
        counts = Counter(item.id for item in items)
        if "" in counts:
            yield f"one of the {noun} has no id"
        for name in sorted(n for n, count in counts.items() if n and count > 1):
            yield f"{counts[name]} of the {noun} are called {name!r}"


def _labels(panel: Panel, most: int) -> Iterator[str]:
    markers = Counter(c.marker_id for c in panel.components)
    for marker in sorted(m for m, count in markers.items() if count > 1):
        yield f"{markers[marker]} components have marker_id {marker}; each needs its own"
    for component in panel.components:
        name = f"component {component.id!r}"
        if component.marker_id >= most >= len(panel.components):
            yield f"{name}: marker_id is {component.marker_id}; allowed: 0 to {most - 1}"
        room = min(component.size[:2]) / (1 + 2 * MARKER_MARGIN)
        yield from within(f"{name}: marker_size", component.marker_size, (MARKER_MIN_M, room))


def _channel(channel: Channel) -> Iterator[str]:
    name = f"channel {channel.id!r}"
    yield from within(f"{name}: width", channel.width, CHANNEL_WIDTH_M)
    if channel.y_max <= channel.y_min:
        yield f"{name}: y_max {channel.y_max} must be above y_min {channel.y_min}"


def _clip(clip: PanelClip, panel: Panel, takes: CellLimits) -> Iterator[str]:
    name = f"clip {clip.id!r}"
    yield from within(f"{name}: wire_diameter", clip.wire_diameter, takes.wire_diameter)
    low = clip.wire_diameter / 2 + CLIP_FLOOR_M
    yield from within(f"{name}: height", clip.height, (low, CLIP_MAX_HEIGHT_M))
    yield from within(f"{name}: length", clip.length, CLIP_LENGTH_M)
    yield from within(f"{name}: retention_force", clip.retention_force, CLIP_RETENTION_N, "N")
    yield from _on_plate(name, clip.pose, clip.length / 2, panel)


def _duct(duct: Duct, panel: Panel, arms: Sequence[Kinematics]) -> Iterator[str]:
    name = f"duct {duct.id!r}"
    yield from within(f"{name}: width", duct.width, DUCT_WIDTH_M)
    least, most = DUCT_HEIGHT_M
    longest = max(arm.fingers.length - DUCT_BELOW_HAND_M for arm in arms)
    limits = (least, max(most, longest))
    yield from within(f"{name}: height", duct.height, limits, remedy="a lower duct, longer fingers")
    if duct.slot_pitch:
        yield from within(
            f"{name}: slot_width", duct.slot_width, (0.001, duct.slot_pitch - FINGER_MIN_M)
        )
        yield from within(f"{name}: slot_bottom", duct.slot_bottom, (0.0, duct.height))
    yield from _on_plate(name, duct.pose, duct.length / 2, panel)


def _rail(rail: Rail, panel: Panel) -> Iterator[str]:
    name = f"rail {rail.id!r}"
    yield from within(f"{name}: width", rail.width, RAIL_WIDTH_M)
    yield from within(f"{name}: height", rail.height, RAIL_HEIGHT_M)
    yield from _on_plate(name, rail.pose, rail.length / 2, panel)


def _on_plate(
    name: str, pose: tuple[float, float, float], half_length: float, panel: Panel
) -> Iterator[str]:
    x, y, yaw = pose
    reach = (abs(x) + half_length * abs(math.cos(yaw)), abs(y) + half_length * abs(math.sin(yaw)))
    if reach[0] > panel.size[0] / 2 + 1e-6 or reach[1] > panel.size[1] / 2 + 1e-6:
        yield f"{name} reaches beyond the plate"


def _component(component: Component, panel: Panel, arms: Sequence[Kinematics]) -> Iterator[str]:
    name = f"component {component.id!r}"
    depth, width, height = component.size
    yield from within(f"{name}: height", height, COMPONENT_HEIGHT_M)
    if min(depth, width) <= 0:
        yield f"{name}: size must be positive"
    for terminal in component.terminals:
        yield from _terminal(terminal, component, panel, arms)
    for side in (0.0, math.pi):
        row = sorted(
            (t for t in component.terminals if abs(wrap_angle(t.insertion_yaw - side)) < 0.01),
            key=lambda t: t.mouth[1],
        )
        for left, right in pairwise(row):
            gap = right.mouth[1] - left.mouth[1] - _half_row(left) - _half_row(right)
            if gap < OPENING_GAP_M - 1e-9:
                pitch = right.mouth[1] - left.mouth[1] + OPENING_GAP_M - gap
                yield (
                    f"{name}: the openings of terminals {left.id!r} and {right.id!r} are "
                    f"{gap * 1e3:.1f} mm apart; at least {OPENING_GAP_M * 1e3:.1f} mm: a pitch of "
                    f"{math.ceil(pitch * 1e3)} mm"
                )
    deepest = sum(
        max(
            (t.depth for t in component.terminals if (math.cos(t.insertion_yaw) > 0) == s),
            default=0,
        )
        for s in (True, False)
    )
    if deepest + 0.002 > depth:
        yield f"{name}: openings of {deepest:.3f} m in all do not fit into its {depth:.3f} m"


def _opening_half(terminal: PanelTerminal) -> float:
    return terminal.bore / 2 + terminal.chamfer


def _half_row(terminal: PanelTerminal) -> float:
    """Return how far a terminal's openings reach from their middle [m]."""
    return terminal.offsets[-1] + _opening_half(terminal)


def _header(terminal: PanelTerminal, name: str) -> Iterator[str]:
    yield from within(f"{name}: ways", terminal.ways, WAYS, "")
    yield from within(f"{name}: retention_force", terminal.retention_force, LATCH_N, "N")
    gap = terminal.pitch - 2 * _opening_half(terminal)
    if gap < OPENING_GAP_M:
        yield (
            f"{name}: its openings are {gap * 1e3:.1f} mm apart; "
            f"at least {OPENING_GAP_M * 1e3:.1f} mm"
        )


def _terminal(
    terminal: PanelTerminal, component: Component, panel: Panel, arms: Sequence[Kinematics]
) -> Iterator[str]:
    name = f"terminal '{component.id}/{terminal.id}'"
    x, y, z = terminal.mouth
    yaw = wrap_angle(terminal.insertion_yaw)
    if min(abs(yaw), abs(wrap_angle(yaw - math.pi))) > 0.01:
        yield f"{name}: insertion_yaw is {terminal.insertion_yaw:.3f} rad; allowed: 0 or pi"
        return
    face = -math.cos(yaw) * component.size[0] / 2
    if abs(x - face) > 0.0005:
        yield f"{name}: its opening is at x {x:.4f} m; the side it opens to is at {face:.4f} m"
    if abs(y) + _half_row(terminal) > component.size[1] / 2:
        yield f"{name}: its opening reaches beyond the component's side"
    yield from within(f"{name}: height of the opening", z, OPENING_HEIGHT_M)
    yield from within(f"{name}: depth", terminal.depth, DEPTH_M)
    yield from within(f"{name}: chamfer", terminal.chamfer, CHAMFER_M)
    yield from within(f"{name}: retention_force", terminal.retention_force, RETENTION_N, "N")
    if terminal.is_header:
        yield from _header(terminal, name)
    if not panel.channels:
        return
    socket = component.panel_from_component @ terminal.component_from_socket
    yield from _reach(name, socket, panel, arms)


def _reach(
    name: str, panel_from_socket: Pose, panel: Panel, arms: Sequence[Kinematics]
) -> Iterator[str]:
    opening, into = panel_from_socket.position, unit_x(panel_from_socket)
    channel = panel.channel_in_front_of(opening)
    edge = channel.x + math.copysign(channel.width / 2, into[0])
    if abs(opening[0] - edge) > OPENING_OFF_EDGE_M:
        yield (
            f"{name}: its opening is at x {opening[0]:.4f} m of the panel; it must open at an edge "
            "of a channel, "
            f"the nearest is channel {channel.id!r} at {edge:.4f} m"
        )
    if not channel.y_min <= opening[1] <= channel.y_max:
        yield f"{name}: at y {opening[1]:.3f} m it lies beyond the end of channel {channel.id!r}"
    yield from within(f"{name}: |y| on the panel", abs(opening[1]), (0.0, TERMINAL_MAX_Y_M))
    tool = panel.world_from_panel.apply(opening - into * (GRASP_DISTANCE_M + STANDOFF_M))
    yaws = (panel_from_socket.yaw, panel_from_socket.yaw + math.pi)
    poses = [ToolPose(tool[0], tool[1], tool[2], yaw) for yaw in yaws]
    if not any(arm.reaches(pose) for arm in arms for pose in poses):
        yield f"{name}: no arm reaches it"


def _overlaps(panel: Panel) -> Iterator[str]:
    half_x, half_y = panel.size[0] / 2, panel.size[1] / 2
    taken = {}
    for component in panel.components:
        x, y, yaw = component.pose
        taken[component.id] = footprint((x, y), component.size[:2], yaw)
        (low_x, low_y), (high_x, high_y) = taken[component.id]
        beyond = max(high_x, -low_x) - half_x, max(high_y, -low_y) - half_y
        if max(beyond) > 1e-6:
            yield f"component {component.id!r} reaches beyond the plate"
    yield from overlaps(taken)


def _wire(wire: PanelWire, panel: Panel, takes: CellLimits) -> Iterator[str]:
    name = f"wire {wire.id!r}"
    if not is_colour(wire.colour):
        yield (
            f"{name}: colour {wire.colour!r} is not known; allowed: one of these codes, or several "
            f"one after another: {' '.join(WIRE_RGB)}"
        )
    if panel.channels:  # where the terminals limit the length
        for sentence in takes.about_diameter(wire.diameter):
            yield f"{name}: {sentence}"
    yield from within(f"{name}: ferrule_length", wire.ferrule_length, FERRULE_M)
    yield from within(f"{name}: linear_density", wire.linear_density, DENSITY_KG_M, "kg/m")
    yield from within(f"{name}: bending_stiffness", wire.bending_stiffness, STIFFNESS_NM2, "N m^2")
    yield from within(
        f"{name}: torsional_stiffness", wire.torsional_stiffness, TORSION_NM2, "N m^2"
    )
    yield from within(f"{name}: friction", wire.friction, FRICTION, "")
    yield from within(f"{name}: rest_curvature", wire.rest_curvature, REST_CURVATURE_1_M, "1/m")
    yield from within(f"{name}: yield_curvature", wire.yield_curvature, YIELD_CURVATURE_1_M, "1/m")
    yield from within(f"{name}: hardening", wire.hardening, HARDENING, "")
    yield from _connectors(wire)
    sockets = {}
    for end in WireEnd:
        component_id, terminal_id = wire.goes_to(end)
        component = next((c for c in panel.components if c.id == component_id), None)
        terminal = (
            next((t for t in component.terminals if t.id == terminal_id), None)
            if component
            else None
        )
        if component is None or terminal is None:
            yield (
                f"{name}: end {end.value} goes to '{component_id}/{terminal_id}', which does not "
                "exist"
            )
            continue
        sockets[end] = component.panel_from_component @ terminal.component_from_socket
        connector = wire.connector_at(end)
        if terminal.is_header or connector is not None:
            yield from _mates(
                name, end, connector, terminal, where=f"'{component_id}/{terminal_id}'"
            )
            continue
        yield from _clearance(name, terminal, wire.diameter, f"'{component_id}/{terminal_id}'")
        if terminal.depth < wire.ferrule_length + DEPTH_BEYOND_FERRULE_M - 1e-9:
            yield (
                f"{name}: the ferrule of {wire.ferrule_length:.4f} m does not hide in "
                f"'{component_id}/{terminal_id}', "
                f"{terminal.depth:.4f} m deep; it must be {DEPTH_BEYOND_FERRULE_M} m deeper"
            )
    if len(sockets) == 2 and panel.channels:
        yield from _wire_length(name, wire, sockets, panel, takes)


def _clearance(name: str, terminal: PanelTerminal, diameter: float, where: str) -> Iterator[str]:
    limits = (OPENING_CLEARANCE_M[0] * 1e3, OPENING_CLEARANCE_M[1] * 1e3)
    what = f"{name}: opening of {where} minus diameter"
    yield from within(what, (terminal.bore - diameter) * 1e3, limits, "mm")


def _mates(
    name: str, end: WireEnd, connector: Connector | None, terminal: PanelTerminal, where: str
) -> Iterator[str]:
    """Check that a connector goes into a header, and nothing else does."""
    if connector is None:
        yield f"{name}: end {end.value} has no connector, and {where} is a header"
        return
    if not connector.fits(terminal):
        yield (
            f"{name}: connector {connector.id!r} has {connector.ways} ways, "
            f"{connector.pitch * 1e3:.2f} mm apart, and {where} has {terminal.ways}, "
            f"{terminal.pitch * 1e3:.2f} mm apart"
        )
    yield from _clearance(name, terminal, connector.pin_diameter, where)
    if terminal.depth < connector.pin_length + DEPTH_BEYOND_PINS_M - 1e-9:
        yield (
            f"{name}: the pins of connector {connector.id!r}, {connector.pin_length:.4f} m long, "
            f"do not go into {where}, {terminal.depth:.4f} m deep; it must be "
            f"{DEPTH_BEYOND_PINS_M} m deeper"
        )


def _connectors(wire: PanelWire) -> Iterator[str]:
    for end in WireEnd:
        count = sum(connector.end is end for connector in wire.connectors)
        if count > 1:
            yield f"wire {wire.id!r}: {count} connectors are at end {end.value}"
    for connector in wire.connectors:
        name = f"connector {connector.id!r}"
        yield from within(f"{name}: ways", connector.ways, WAYS, "")
        yield from within(f"{name}: pin_diameter", connector.pin_diameter, PIN_DIAMETER_M)
        yield from within(f"{name}: pin_length", connector.pin_length, PIN_LENGTH_M)
        yield from within(f"{name}: body_length", connector.body_length, BODY_LENGTH_M)
        row = 2 * connector.offsets[-1] + connector.pin_diameter
        width = (max(row, BODY_WIDTH_M[0]), BODY_WIDTH_M[1])
        yield from within(f"{name}: body_width", connector.body_width, width)
        yield from within(f"{name}: mating_force", connector.mating_force, MATING_N, "N")


def _wire_length(
    name: str,
    wire: PanelWire,
    sockets: dict[WireEnd, Pose],
    panel: Panel,
    takes: CellLimits,
) -> Iterator[str]:
    a, b = sockets[WireEnd.A].position, sockets[WireEnd.B].position
    crossing = panel.channel_in_front_of(a) != panel.channel_in_front_of(b)
    direction = feed_direction(float(a[1]), float(b[1]))
    span, (shortest, longest) = abs(b[1] - a[1]), takes.wire_length
    least, most = CROSSING_BEYOND_M if crossing else LENGTH_BEYOND_M
    low = max(shortest, span + least)
    high = min(longest, max(low, span + most), FEED_REACH_M - direction * a[1])
    yield from within(f"{name}: length between these terminals", wire.length, (low, high))


def feed_direction(y_a: float, y_b: float) -> int:
    """Return +1 when a wire is laid from a towards +y.

    Towards its other terminal, else where there is more room.
    """
    if abs(y_b - y_a) > 0.03:
        return 1 if y_b > y_a else -1
    return 1 if y_a <= 0 else -1


def _sharing(panel: Panel) -> Iterator[str]:
    users = Counter(wire.goes_to(end) for wire in panel.wires for end in WireEnd)
    for (component_id, terminal_id), count in users.items():
        if count > 1:
            yield f"{count} wire ends go to '{component_id}/{terminal_id}'; a terminal takes one"
