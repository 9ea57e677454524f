"""Carry a held end over the panel and lay it down, as steps of an ability."""

from __future__ import annotations

import numpy as np

from remodel_skills.belief_state import EndState, Grip
from remodel_skills.primitives.grasping import check_grip, release
from remodel_skills.primitives.motions import move_to, rise, wait
from remodel_skills.robot_context import RobotContext, Steps
from remodel_work.cell.presenting import FORK_BEHIND_GRASP_M
from remodel_work.geometry import Array
from remodel_work.robot.arm import ToolPose


def lay_down(
    context: RobotContext, target: ToolPose, shares: tuple[float, float], *, fork: bool = True
) -> Steps[None]:
    """Carry the held end to a tool pose, release it, and lift the empty hand.

    `fork`: whether the feeder's fork may come up around it.
    """
    first, last = shares
    context.report("carrying the end to where it is laid down", first)
    yield from carry_over(context, target)
    check_grip(context)
    context.report("laying the end down", first + 0.6 * (last - first))
    yield from move_to(context, target, context.parameters.motion.approach_speed_m_s)
    grip = context.belief.grip
    if grip is not None:
        tip = tip_of(target, grip)
        context.belief.expected[grip.end] = np.array([*tip, context.wire.radius])
        context.belief.tips.pop(grip.end, None)
        if fork:
            _bring_fork(context, target, grip)
    yield from release(context, context.parameters.tool.open_m)
    yield from rise(context)


def let_down(context: RobotContext) -> Steps[None]:
    """Lift the held end over its neighbours and release it: it comes to rest on what is there.

    For an end from the magazine, which has no place on the board but its terminal.
    """
    motion = context.parameters.motion
    yield from rise(context, context.commanded.z + motion.let_down_above_m)
    check_grip(context)
    grip = context.belief.grip
    if grip is not None:
        tip = tip_of(context.commanded, grip)
        context.belief.expected[grip.end] = np.array([*tip, context.wire.radius])
        context.belief.tips.pop(grip.end, None)
    yield from release(context, context.parameters.tool.open_m)
    yield from rise(context)
    yield from wait(context, motion.settled_s)


def _bring_fork(context: RobotContext, tool: ToolPose, grip: Grip) -> None:
    """Hold an end in the middle of its channel.

    A wire that is fixed at the other end would spring to a side.
    """
    belief = context.belief
    if belief.feed is None or belief.by_magazine:
        return
    if belief.ends[grip.end.other] is EndState.LOOSE:
        return
    channel = context.panel.channel(belief.feed.channel_id)
    middle = context.panel.world_from_panel.position[0] + channel.x
    if abs(tool.x - middle) < context.parameters.fixture.feeder_fork_tolerance_m:
        behind = np.array([tool.x, tool.y]) - tip_of(tool, grip)
        behind *= FORK_BEHIND_GRASP_M / np.linalg.norm(behind)
        context.device.magazine.move_fork(middle, tool.y + float(behind[1]))


def tip_of(tool: ToolPose, grip: Grip) -> Array:
    """Return where the held tip is for a tool pose, (2,) [m]."""
    yaw = tool.yaw + grip.flip
    return np.array([tool.x, tool.y]) + grip.distance * np.array([np.cos(yaw), np.sin(yaw)])


def carry_over(context: RobotContext, target: ToolPose) -> Steps[None]:
    """Bring the held end above a tool pose, turned as there.

    Low within a channel, else over the rows. One from the magazine, or with other wires there,
    turns high up and comes straight down, between its neighbours.
    """
    motion = context.parameters.motion
    now, among_others = context.commanded, context.belief.by_magazine or len(context.belief.fed) > 1
    if among_others:
        yield from rise(context)
        yield from move_to(context, target.at(z=context.commanded.z), motion.carry_speed_m_s)
        yield from move_to(
            context, target.at(z=target.z + motion.above_target_m), motion.approach_speed_m_s
        )
    elif abs(now.x - target.x) > motion.low_carry_m:
        yield from move_to(context, now.at(z=motion.travel_z_m), motion.free_speed_m_s / 2)
        yield from move_to(
            context,
            ToolPose(target.x, target.y, motion.travel_z_m, now.yaw),
            motion.carry_speed_m_s,
        )
        yield from move_to(
            context, context.commanded.at(z=motion.carry_z_m), motion.approach_speed_m_s
        )
    elif now.z > motion.carry_z_m:
        yield from move_to(
            context, ToolPose(target.x, target.y, now.z, now.yaw), motion.carry_speed_m_s
        )
        yield from move_to(
            context, context.commanded.at(z=motion.carry_z_m), motion.approach_speed_m_s
        )
    if not among_others:
        yield from move_to(context, target.at(z=motion.carry_z_m), motion.carry_speed_m_s)
