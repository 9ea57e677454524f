"""Carry a held wire, lay its end down, or drop it into the scrap bin, as steps of an ability.

The hand stops when the wire snags.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from remodel_skills.belief_state import EndState, Grip
from remodel_skills.primitives.grasping import check_grip, release
from remodel_skills.primitives.motions import (
    fingers_still,
    move_to,
    nearest_hand_yaw,
    rise,
    wait,
)
from remodel_skills.primitives.picking_up import end_wire
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.standing import new_length
from remodel_work.camera import Picture
from remodel_work.cell.cell_design import bin_of
from remodel_work.cell.presenting import FORK_BEHIND_GRASP_M
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose


def carry(
    context: RobotContext, tool: ToolPose, speed: float, free: Array, most: float | None = None
) -> Steps[None]:
    """Move as `move_to`; raises SNAGGED, the arm stopped, when the wire pulls back.

    Args:
        context: the cell, a wire in its hand.
        tool: where to.
        speed: peak speed of the tool centre [m/s].
        free: what the wrist feels without the wire's pull, world frame (3,) [N].
        most: by which it may pull, level [N]; None for what a free wire of its stiffness does.
    """
    wire = context.parameters.wire
    if most is None:
        most = wire.snagged_n(context.wire.bending_stiffness)
    pulled_s = 0.0
    for _ in move_to(context, tool, speed):
        yield
        pull = float(np.linalg.norm((context.device.arm.force - free)[:2]))
        pulled_s = pulled_s + context.tick_s if pull > most else 0.0
        if pulled_s > wire.snag_s:
            context.follow(context.device.arm.tool)
            raise AbilityError(
                Code.SNAGGED,
                f"{context.wire.id!r} pulls at the hand with {pull:.0f} N at "
                f"{context.device.arm.tool}: it hangs on something or is too short; "
                "move back, observe it, take another route",
            )


def drop_into_bin(context: RobotContext, shares: tuple[float, float]) -> Steps[None]:
    """Carry the wire in the hand over the robot's scrap bin, open, and see that it is gone.

    Raises:
        AbilityError: SNAGGED, GRASP_SLIPPED, also when it lies on the board.
    """
    tool = context.parameters.tool
    first, last = shares
    before = tuple(context.belief.untouched) or context.cameras.take_overhead_pictures()
    context.report("carrying the wire to the scrap bin", first)
    above_bin = bin_of(context.design, context.panel)
    context.device.magazine.lower_fork()
    yield from rise(context, _drawn_up_z(context, above_bin.z))
    now = context.commanded
    yaw = nearest_hand_yaw(context.arm, above_bin.x, above_bin.y, now.yaw, near=now.yaw)
    over = ToolPose(above_bin.x, above_bin.y, now.z, yaw)
    # Where it was drawn out, the wire may still pull.
    yield from carry(
        context,
        over,
        context.parameters.motion.carry_speed_m_s,
        context.empty_force,
        most=tool.grip_holds_n,
    )
    check_grip(context)
    context.report("dropping the wire", first + 0.8 * (last - first))
    context.drive_fingers(tool.open_m)
    yield from fingers_still(context)
    context.device.magazine.drop(context.device.arm.tool.position)
    context.belief.grip = None
    _check_gone(context, before)
    end_wire(context)


def _check_gone(context: RobotContext, before: Sequence[Picture]) -> None:
    """Raise GRASP_SLIPPED when the dropped wire is seen on the board.

    There is no step in between, so that a cancel leaves a wire either in the bin or known. What the
    wire or an arm covered in the picture from before is not compared.
    """
    pictures = context.cameras.take_overhead_pictures()
    hands = [robot.device.arm.tool.position for robot in context.robots.values()]
    pairs = [(seen, each) for seen in pictures for each in before if seen.view.is_at(each.view)]
    length = new_length(pairs, context.panel, context.wire.radius, hands)
    if length > context.parameters.looking.least_seen_m:
        raise AbilityError(
            Code.GRASP_SLIPPED,
            f"{context.wire.id!r} is still seen on the board after it was dropped, along "
            f"{length * 1e3:.0f} mm: it slipped out of the fingers; detect it again",
        )


def lift_out(context: RobotContext) -> Steps[None]:
    """Lift the wire out of its ducts along its route, from the held end on.

    Drawn along its ducts, it would hang on corners and on the wires that lie over it.

    Raises:
        AbilityError: SNAGGED, GRASP_SLIPPED.
    """
    motion = context.parameters.motion
    yield from rise(context)
    grip = context.belief.grip
    assert grip is not None, "the wire is in the hand"
    points = [context.panel.world_from_panel.apply(np.array(point)) for point in context.wire.route]
    if grip.end is WireEnd.B:
        points.reverse()
    lifted, highest = 0.0, _drawn_up_z(context, motion.travel_z_m)
    for before, (x, y, z) in pairwise(points[:-1]):
        lifted += math.dist(before, (x, y, z))
        above = ToolPose(
            x, y, min(highest, max(motion.travel_z_m, z + lifted)), context.commanded.yaw
        )
        if context.arm.reaches(above):
            yield from carry(
                context,
                above,
                motion.carry_speed_m_s,
                context.empty_force,
                most=context.parameters.tool.grip_holds_n,
            )
            check_grip(context)


def _drawn_up_z(context: RobotContext, least: float) -> float:
    """Return the height to which the hand draws the wire up [m]: out of its ducts, if it has any.

    Drawn aside, it would catch on their walls.
    """
    if not context.wire.ducts:
        return least
    heights = np.linspace(
        max(least, context.wire.length), least, context.parameters.motion.drawn_up_heights
    )
    reached = (z for z in heights if context.arm.reaches(context.commanded.at(z=float(z))))
    return float(next(reached, least))


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
