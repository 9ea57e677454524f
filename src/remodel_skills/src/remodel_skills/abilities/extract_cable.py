"""ExtractCable: open the terminal, pull the wire's end out, and lay it down in its channel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import EndState, Grip
from remodel_skills.goal_checks import Message, pose_from
from remodel_skills.goals import ExtractGoal
from remodel_skills.primitives.carrying import lay_down, let_down, tip_of
from remodel_skills.primitives.force_motion import pull_out
from remodel_skills.primitives.grasping import (
    close_on_wire,
    grasp_distance,
    holds,
    opening_beside_neighbours,
)
from remodel_skills.primitives.in_ducts import let_go
from remodel_skills.primitives.motions import choose_flip, clear_hand, move_to, swing_to
from remodel_skills.primitives.picking_up import take_up
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose


@dataclass(frozen=True)
class CableExtracted:
    """An end laid down, the hand empty.

    Attributes:
        message: for a person.
        peak_force: largest axial force at the wrist during the pull [N].
    """

    message: str
    peak_force: float


def _goal(message: Message, board: Pose) -> ExtractGoal:
    return ExtractGoal(
        robot_name=message.robot_name,
        cable_id=message.cable_id,
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        socket=pose_from("socket_pose", message.socket_pose, board),
    )


@ability("ExtractCable", _goal)
def extract_cable(context: RobotContext, goal: ExtractGoal) -> Steps[CableExtracted]:
    """Bring the wire back to where its end lies loose in the channel, from wherever it is."""
    end, peak = yield from draw_out(context, goal)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    if context.belief.grip is None:
        context.report("clearing the hand", 0.5)
        yield from clear_hand(context)
        return CableExtracted(f"nothing to pull out of {where}: end {end.value} lies loose", 0.0)
    yield from put_away(context, (0.6, 1.0))
    return CableExtracted(f"end {end.value} of {goal.cable_id} out of {where}, laid down", peak)


def draw_out(context: RobotContext, goal: ExtractGoal) -> Steps[tuple[WireEnd, float]]:
    """Draw an end out of its terminal, and keep it in the hand.

    Returns:
        Which end, and the largest axial force at the wrist [N]. The hand is empty if the end was
        neither in the hand nor in the terminal: it lies loose.
    """
    belief = context.belief
    take_up(context, goal.cable_id)
    yield from let_go(context)
    end = _end_at(context, goal)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    if belief.grip is not None and not holds(context):
        belief.grip = None  # it slipped out; the end may sit in the terminal
    in_opening = belief.engaged is not None or belief.ends[end] is not EndState.LOOSE
    if belief.grip is None and in_opening:
        # Before the terminal opens: a bent wire springs out of one that is open.
        yield from _regrasp(context, end, goal)
    context.report(f"opening {where}", 0.3)
    context.device.fixture.open_clamp(goal.component_id, goal.terminal_id)
    peak = 0.0
    if belief.grip is None:
        belief.engaged = None
    elif belief.engaged is not None:
        context.report(f"pulling end {end.value} out of {where}", 0.4)
        peak = yield from pull_out(context, belief.engaged, context.parameters.tool.grip_holds_n)
    belief.loosen(end)
    return end, peak


def put_away(context: RobotContext, shares: tuple[float, float]) -> Steps[None]:
    """Lay the held end down where it was picked, or let it down where it is.

    An end from the magazine does not go back there.
    """
    grip = context.belief.grip
    if grip is None:
        return
    if context.belief.by_magazine:
        yield from let_down(context)
    else:
        target = where_it_lay(context, grip, context.belief.picked_at[grip.end])
        yield from lay_down(context, target, shares)


def where_it_lay(context: RobotContext, grip: Grip, back: Grip) -> ToolPose:
    """Return the tool pose that lays the tip down where it lay when it was picked."""
    yaw = back.tool.yaw + back.flip
    x, y = tip_of(back.tool, back) - grip.distance * np.array([math.cos(yaw), math.sin(yaw)])
    z = max(
        context.wire.radius - grip.height,
        context.fingers.below + context.parameters.tool.floor_clearance_m,
    )
    return ToolPose(float(x), float(y), z, yaw - grip.flip)


def _end_at(context: RobotContext, goal: ExtractGoal) -> WireEnd:
    """Return which end is meant.

    The one in the hand, the one in that terminal, or the one that belongs there.
    """
    belief = context.belief
    if belief.grip is not None:
        return belief.grip.end
    occupant = belief.occupied.get((goal.component_id, goal.terminal_id))
    if occupant is not None and occupant[0] == goal.cable_id:
        return occupant[1]
    belongs = context.wire.goes_to(WireEnd.B) == (goal.component_id, goal.terminal_id)
    return WireEnd.B if belongs else WireEnd.A


def _regrasp(context: RobotContext, end: WireEnd, goal: ExtractGoal) -> Steps[None]:
    """Grasp the wire at the opening; the hand stays empty if it is not there."""
    context.report("grasping the wire at the opening", 0.1)
    terminal = context.panel.component(goal.component_id).terminal(goal.terminal_id)
    connector = context.wire.connector_at(end)
    inside = terminal.depth if connector is None else connector.pin_length
    try:
        yield from _grasp_at_opening(context, end, goal, inside)
    except AbilityError as error:
        if error.code is not Code.GRASP_MISSED:
            raise


def _grasp_at_opening(
    context: RobotContext, end: WireEnd, goal: ExtractGoal, inside: float
) -> Steps[None]:
    """Grasp the wire just outside an opening; `inside` [m] of it are in the terminal."""
    motion = context.parameters.motion
    socket, terminal = goal.socket, (goal.component_id, goal.terminal_id)
    then = context.belief.picked_at[end]
    # Between a terminal and a duct there is no more room than an insertion takes.
    by_magazine = context.belief.by_magazine
    outside = context.fingers.width / 2 + context.parameters.tool.pads_clear_m
    distance = grasp_distance(context, end) if by_magazine else inside + outside
    place = tool_before(
        socket, Grip(end=end, distance=distance, height=0.0, flip=0.0, tool=then.tool), inside
    )
    flip = choose_flip(
        context.arm,
        (place.x, place.y),
        socket.yaw,
        (then.tool.x, then.tool.y),
        then_tip_yaw=then.tool.yaw + then.flip,
    )
    tool = ToolPose(place.x, place.y, place.z, socket.yaw - flip)
    yield from clear_hand(context)
    yield from swing_to(context, tool.at(z=max(motion.travel_z_m, context.commanded.z)))
    context.drive_fingers(opening_beside_neighbours(context, terminal))
    yield from move_to(context, tool.at(z=tool.z + motion.approach_above_m), motion.free_speed_m_s)
    yield from move_to(context, tool, motion.approach_speed_m_s)
    picked = context.belief.picked_at[end]
    yield from close_on_wire(
        context, Grip(end=end, distance=distance, height=0.0, flip=flip, tool=tool)
    )
    context.belief.picked_at[end] = picked
    context.belief.engaged = socket
