"""The rules of a panel without channels: a board with ducts, whose wires a magazine presents.

Each problem says what does not fit, by how much, and what would change it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from remodel_states.core.cell import CellLimits, objections
from remodel_work.geometry import Pose, wrap_angle
from remodel_work.panel import Component, Duct, Panel, PanelWire, WireEnd, unit_x
from remodel_work.robot.arm import Kinematics, ToolPose

# Tool centre to tip where devices stand before ducts [m]: farther off, slim fingers do not fit
# between a device and the duct before it.
GRASP_M = 0.025
# Between a finger and the wire in the next terminal.
FINGER_PLAY_M = 0.0005
# How far out of reach a terminal is, is found in steps of [m], up to this.
STEP_M = 0.02
FARTHEST_M = 1.0

# Openings by component and terminal; x points into the terminal, world frame.
Sockets = Mapping[tuple[str, str], Pose]


def board_problems(
    panel: Panel, arms: Sequence[Kinematics], takes: CellLimits, standoff_m: float
) -> Iterator[str]:
    """Yield what of a board the arms cannot wire, a sentence each; nothing of one with channels.

    `standoff_m` is from the tip to the opening before an end is pushed in.
    """
    if panel.channels:
        return
    yield from _reach(arms, _sockets(panel), standoff_m)
    yield from _room(panel, arms, standoff_m)
    yield from _neighbours(panel, arms)
    for wire in panel.wires:
        yield from _wire(wire, panel, takes)


def _sockets(panel: Panel) -> Sockets:
    """Return the openings that wires go to, in the world's frame."""
    openings = {
        (component.id, terminal.id): component.panel_from_component @ terminal.component_from_socket
        for component in panel.components
        for terminal in component.terminals
    }
    ends = dict.fromkeys(wire.goes_to(end) for wire in panel.wires for end in WireEnd)
    return {end: panel.world_from_panel @ openings[end] for end in ends if end in openings}


def _reach(arms: Sequence[Kinematics], sockets: Sockets, standoff_m: float) -> Iterator[str]:
    """One sentence for all terminals that no arm reaches, with the farthest of them."""
    poses = {name: _tools(socket, standoff_m) for name, socket in sockets.items()}
    missed = [name for name, tools in poses.items() if not _reached(arms, tools)]
    if not missed:
        return
    offs = {name: _out_of_reach(arms, poses[name]) for name in missed}
    farthest = max(missed, key=lambda name: offs[name][0])
    off, towards = offs[farthest]
    named = ", ".join("'{}/{}'".format(*name) for name in missed[:3])
    more = f" and {len(missed) - 3} more" if len(missed) > 3 else ""
    by = f"{off:.2f} m towards {towards}" if towards else f"more than {FARTHEST_M:g} m"
    yield (
        f"no arm reaches {len(missed)} of {len(sockets)} terminals: {named}{more}; "
        "'{}/{}' is out of reach by {}: ".format(*farthest, by)
        + ("a longer axis, " if towards.endswith("y") else "")
        + "a base nearer to it, or a smaller board"
    )


def _tools(socket: Pose, standoff_m: float) -> list[ToolPose]:
    x, y, z = socket.position - unit_x(socket) * (GRASP_M + standoff_m)
    return [ToolPose(x, y, z, socket.yaw + turn) for turn in (0.0, math.pi)]


def _reached(arms: Sequence[Kinematics], tools: Sequence[ToolPose]) -> bool:
    return any(arm.reaches(tool) for arm in arms for tool in tools)


def _out_of_reach(arms: Sequence[Kinematics], tools: Sequence[ToolPose]) -> tuple[float, str]:
    """Return by how much [m] an arm would have to stand nearer, and in which direction."""
    directions = {"+x": (1, 0), "-x": (-1, 0), "+y": (0, 1), "-y": (0, -1)}
    for off in np.arange(STEP_M, FARTHEST_M, STEP_M):
        for name, (x, y) in directions.items():
            nearer = [ToolPose(t.x - off * x, t.y - off * y, t.z, t.yaw) for t in tools]
            if _reached(arms, nearer):
                return float(off), name
    return FARTHEST_M, ""


def _room(panel: Panel, arms: Sequence[Kinematics], standoff_m: float) -> Iterator[str]:
    """Between an opening and the wall of the duct before it: wire, fingers, standoff."""
    width = min(arm.fingers.width for arm in arms)
    needed = GRASP_M + standoff_m + width / 2
    for component in panel.components:
        for yaw in {terminal.insertion_yaw for terminal in component.terminals}:
            rooms = [
                (_room_before(panel, component, terminal.id, duct), duct.id)
                for terminal in component.terminals
                if terminal.insertion_yaw == yaw
                for duct in panel.ducts
            ]
            room, duct_id = min(rooms, default=(math.inf, ""))
            if room < needed - 1e-6:
                yield (
                    f"component {component.id!r}: {room * 1e3:.0f} mm from its openings to duct "
                    f"{duct_id!r}, {(needed - room) * 1e3:.1f} mm too little for the hand: rows "
                    "further apart, or a narrower duct"
                )


def _room_before(panel: Panel, component: Component, terminal_id: str, duct: Duct) -> float:
    """Return the distance from an opening straight out to a duct's nearer wall [m]."""
    socket = panel.panel_from_socket(component.id, terminal_id)
    frame = duct.panel_from_duct.inverse()
    x, y, _ = frame.apply(socket.position)
    out_y = float((frame.rotation @ -unit_x(socket))[1])
    if abs(out_y) < 0.5 or abs(x) > duct.length / 2 or y * out_y >= 0:
        return math.inf
    return float(abs(y) - duct.width / 2)


def _neighbours(panel: Panel, arms: Sequence[Kinematics]) -> Iterator[str]:
    """One sentence for all terminals that are too near to the next one for a finger."""
    finger = min(arm.fingers.outer_m for arm in arms)
    thick = {wire.goes_to(end): wire.diameter for wire in panel.wires for end in WireEnd}
    narrow: list[tuple[float, float, str]] = []
    for component in panel.components:
        for side in (0.0, math.pi):
            row = [
                t
                for t in sorted(component.terminals, key=lambda t: t.mouth[1])
                if abs(wrap_angle(t.insertion_yaw - side)) < 0.01 and (component.id, t.id) in thick
            ]
            for left, right in pairwise(row):
                wires = thick[component.id, left.id] + thick[component.id, right.id]
                needed = wires / 2 + finger + FINGER_PLAY_M
                pitch = right.mouth[1] - left.mouth[1]
                if pitch < needed - 1e-6:
                    narrow.append((needed - pitch, needed, f"'{component.id}/{left.id}'"))
    if narrow:
        lack, needed, name = max(narrow)
        yield (
            f"{len(narrow)} terminals are too near to the next one for a finger of "
            f"{finger * 1e3:.1f} mm between their wires, {name} by {lack * 1e3:.1f} mm: a pitch of "
            f"{math.ceil(needed * 1e3)} mm, or thinner fingers"
        )


def _wire(wire: PanelWire, panel: Panel, takes: CellLimits) -> Iterator[str]:
    name = f"wire {wire.id!r}"
    ducts = {duct.id: duct for duct in panel.ducts}
    for duct_id in dict.fromkeys(wire.ducts):
        if duct_id not in ducts:
            there_are = ", ".join(ducts) or "none"
            yield f"{name}: its route passes duct {duct_id!r}; the panel has: {there_are}"
    passages = [ducts[duct_id].passage for duct_id in wire.ducts if duct_id in ducts]
    for objection in objections(takes, wire.length, wire.diameter, wire.route, passages):
        yield f"{name}: {objection.sentence}"
