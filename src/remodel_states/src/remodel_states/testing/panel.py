"""Between messages and the values of a fake cell's world."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from remodel_msgs import msg as remodel_msgs
from remodel_msgs.msg import CableObservation, WireTruth

from remodel_states.testing.world import Panel, Place, World


def panel_from(message: remodel_msgs.Panel) -> Panel:
    """Return the panel of a message.

    Raises:
        ValueError: with every name that is used and not there.
    """
    places, openings = {}, {}
    for component in message.components:
        pose = component.pose
        places[component.id] = (pose.x, pose.y, 0.0, pose.theta)
        for terminal in component.terminals:
            openings[f"{component.id}/{terminal.id}"] = _opening(places[component.id], terminal)
    wires = {
        wire.id: (f"{wire.a_component}/{wire.a_terminal}", f"{wire.b_component}/{wire.b_terminal}")
        for wire in message.wires
    }
    missing = [
        f"wire {wire!r} goes to {terminal!r}, which is not there"
        for wire, terminals in wires.items()
        for terminal in terminals
        if terminal not in openings
    ]
    if missing:
        raise ValueError("; ".join(missing))
    return Panel(
        message.name,
        wires,
        {wire.id: wire.length for wire in message.wires},
        places,
        openings=openings,
        channels=tuple(channel.id for channel in message.channels),
        ducts={wire.id: tuple(wire.ducts) for wire in message.wires if wire.ducts},
        serial=message.serial,
    )


def result_fields(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return what an ability found out as fields of its result message."""
    fields = dict(found)
    if "observation" in fields:
        fields["observation"] = _observation(*fields["observation"])
    return {n: _pose(value) if isinstance(value, tuple) else value for n, value in fields.items()}


def truth_of(world: World, wire: str) -> WireTruth:
    """Return where a wire is."""
    truth = WireTruth(wire_id=wire, placed=world.is_placed(wire))
    for end in "ab":
        seat = world.seat(wire, end)
        if seat is not None:
            setattr(truth, f"{end}_at", seat.terminal)
            setattr(truth, f"{end}_fixed", seat.fixed)
    return truth


def _opening(component: Place, terminal: remodel_msgs.Terminal) -> Place:
    x, y, _, yaw = component
    opening = terminal.mouth
    return (
        x + opening.x * math.cos(yaw) - opening.y * math.sin(yaw),
        y + opening.x * math.sin(yaw) + opening.y * math.cos(yaw),
        opening.z,
        yaw + terminal.insertion_yaw,
    )


def _observation(cable_id: str, length_m: float, loose_ends: int) -> CableObservation:
    tips = [_pose((0.0, 0.0, 0.0, 0.0)) for _ in range(loose_ends)]
    return CableObservation(
        cable_id=cable_id,
        centreline=[],
        tips=tips,
        length=length_m,
        confidence=1.0,
        truncated=False,
    )


def _pose(place: Place) -> PoseStamped:
    x, y, z, yaw = place
    pose = PoseStamped(pose=Pose(Point(x, y, z), Quaternion(0, 0, math.sin(yaw / 2), 0)))
    pose.pose.orientation.w = math.cos(yaw / 2)
    pose.header.frame_id = "panel"
    return pose
