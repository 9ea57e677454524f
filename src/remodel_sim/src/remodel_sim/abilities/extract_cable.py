"""ExtractCable: open the terminal, pull the wire's end out, and lay it down in its channel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from remodel_sim.abilities.ability import ability
from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.primitives.grasping import FLOOR_CLEARANCE_M, close_on_wire, holds
from remodel_sim.abilities.primitives.laying import lay_down, tip_of
from remodel_sim.abilities.primitives.motions import (
    APPROACH_SPEED,
    FREE_SPEED,
    HAND_OPEN_M,
    TRAVEL_Z,
    choose_flip,
    clear_hand,
    move_to,
    swing_to,
)
from remodel_sim.abilities.primitives.pulling_out import pull_out
from remodel_sim.abilities.primitives.pushing import tool_before
from remodel_sim.core.belief.belief_state import EndState, Grip
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose
from remodel_sim.core.goals import ExtractGoal
from remodel_sim.core.goals.goal_pose import pose_from
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.workpiece.panel import End
from remodel_sim.physics.robot_description import PAD_BELOW_TOOL_M
from remodel_states.core.codes import Code

# An end that does not come at this force is stuck: the grip holds not much more.
MAX_PULL_N = 25.0
# The wire leaves the bore straight only for so far; there it is grasped, the pads clear of the
# face.
OUTSIDE_M = 0.016


@dataclass(frozen=True)
class CableExtracted:
    """An end laid down, the hand empty.

    Attributes:
        message: for a person.
        peak_force: largest axial force at the wrist during the pull [N].
    """

    message: str
    peak_force: float


def _goal(message: Any) -> ExtractGoal:  # noqa: ANN401 - messages have no types
    return ExtractGoal(
        message.robot_name,
        message.cable_id,
        message.component_id,
        message.terminal_id,
        pose_from("socket_pose", message.socket_pose),
    )


@ability("ExtractCable", _goal)
def extract_cable(station: Station, goal: ExtractGoal) -> Steps[CableExtracted]:
    """Bring the wire back to where its end lies loose in the channel, from wherever it is."""
    book = station.book
    station.make_live(goal.cable_id)
    end = _end_at(station, goal)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    if book.grip is not None and not holds(station):
        book.grip = None  # it slipped out; the end may sit in the bore
    in_mouth = book.engaged is not None or book.ends[end] is not EndState.LOOSE
    station.report(f"opening {where}", 0.05)
    station.open_clamp(goal.component_id, goal.terminal_id)
    if book.grip is None and in_mouth:
        in_mouth = yield from _regrasp(station, end, goal)
    if book.grip is None and not in_mouth:
        station.report("clearing the hand", 0.5)
        yield from clear_hand(station)
        book.engaged = None
        book.loosen(end)
        return CableExtracted(f"nothing to pull out of {where}: end {end.value} lies loose", 0.0)
    peak = 0.0
    if book.engaged is not None:
        station.report(f"pulling end {end.value} out of {where}", 0.4)
        peak = yield from _pull_out(station, book.engaged, where)
    book.loosen(end)
    if book.grip is not None:
        target = where_it_lay(station, book.grip, book.picked_at[end])
        yield from lay_down(station, target, (0.6, 1.0))
    return CableExtracted(f"end {end.value} of {goal.cable_id} out of {where}, laid down", peak)


def where_it_lay(station: Station, grip: Grip, back: Grip) -> ToolPose:
    """Return the tool pose that lays the tip down where it lay when it was picked."""
    yaw = back.tool.yaw + back.flip
    x, y = tip_of(back.tool, back) - grip.distance * np.array([math.cos(yaw), math.sin(yaw)])
    z = max(station.wire.radius - grip.height, PAD_BELOW_TOOL_M + FLOOR_CLEARANCE_M)
    return ToolPose(float(x), float(y), z, yaw - grip.flip)


def _end_at(station: Station, goal: ExtractGoal) -> End:
    """Return which end is meant.

    The one in the hand, the one in that terminal, or the one that belongs there.
    """
    book = station.book
    if book.grip is not None:
        return book.grip.end
    occupant = book.occupant((goal.component_id, goal.terminal_id))
    if occupant is not None and occupant[0] == goal.cable_id:
        return occupant[1]
    belongs = station.wire.goes_to(End.B) == (goal.component_id, goal.terminal_id)
    return End.B if belongs else End.A


def _regrasp(station: Station, end: End, goal: ExtractGoal) -> Steps[bool]:
    """Grasp the wire at the mouth; return whether it is there."""
    station.report("grasping the wire at the mouth", 0.1)
    terminal = station.panel.component(goal.component_id).terminal(goal.terminal_id)
    connector = station.wire.connector_at(end)
    inside = terminal.depth if connector is None else connector.pin_length
    try:
        yield from _grasp_at_mouth(station, end, goal.socket, inside)
    except AbilityError as error:
        if error.code is not Code.GRASP_MISSED:
            raise
        return False
    return True


def _grasp_at_mouth(station: Station, end: End, socket: Pose, inside: float) -> Steps[None]:
    """Grasp the wire just outside a mouth; `inside` [m] of it are in the bore."""
    then = station.book.picked_at[end]
    distance = inside + OUTSIDE_M
    place = tool_before(socket, Grip(end, distance, 0.0, 0.0, then.tool), inside)
    flip = choose_flip(
        station.arm,
        (place.x, place.y),
        socket.yaw,
        (then.tool.x, then.tool.y),
        then.tool.yaw + then.flip,
    )
    tool = ToolPose(place.x, place.y, place.z, socket.yaw - flip)
    yield from clear_hand(station)
    yield from swing_to(station, tool.at(z=max(TRAVEL_Z, station.commanded.z)))
    station.drive_fingers(HAND_OPEN_M)
    yield from move_to(station, tool.at(z=tool.z + 0.03), FREE_SPEED)
    yield from move_to(station, tool, APPROACH_SPEED)
    picked = station.book.picked_at[end]
    yield from close_on_wire(station, Grip(end, distance, 0.0, flip, tool))
    station.book.picked_at[end] = picked
    station.book.engaged = socket


def _pull_out(station: Station, socket: Pose, where: str) -> Steps[float]:
    """Draw the held end out of the mouth; return the peak force [N]."""
    try:
        return (yield from pull_out(station, socket, MAX_PULL_N))
    except AbilityError as error:
        if error.code is Code.EXTRACTION_STUCK:
            text = f"the end in {where}: {error}; ask the operator"
            raise AbilityError(error.code, text, **error.found) from error
        raise
