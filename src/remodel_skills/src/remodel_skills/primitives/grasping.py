"""Grasp a loose end by friction, as steps of an ability."""

from __future__ import annotations

import math

import numpy as np

from remodel_skills.belief_state import EndState, Grip
from remodel_skills.primitives.motions import choose_flip, fingers_still, move_to, rise
from remodel_skills.primitives.observation.observing import GraspObservation, observe_end
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.board_rules import GRASP_M
from remodel_work.cell.presenting import grasp_before_clips
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose, wrap_angle
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import WireEnd, unit_x
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import TerminalKey


def pick_end(
    context: RobotContext, end: WireEnd, distance: float, socket: Pose, shares: tuple[float, float]
) -> Steps[None]:
    """Find a loose end, grasp it and lift it a little.

    Args:
        context: the cell; its hand is empty.
        end: of the live wire.
        distance: from the tip to the grasp along the wire [m]; 0: `grasp_distance`.
        socket: where the end is to go: the hand is turned so that it can insert there.
        shares: of the ability's progress at the start and at the end.
    """
    motion = context.parameters.motion
    distance = distance or grasp_distance(context, end)
    first, last = shares
    context.report(f"searching for end {end.value} of {context.wire.id}", first)
    seen = yield from observe_end(context, end, distance)
    context.report(f"grasping end {end.value}", first + 0.6 * (last - first))
    _check_room(context, seen)
    tool, flip = _grasp_pose(context, seen, distance, socket)
    yield from move_to(context, tool.at(z=context.commanded.z), motion.free_speed_m_s)
    context.drive_fingers(context.parameters.tool.open_m)
    yield from move_to(
        context,
        tool.at(z=max(motion.approach_z_m, tool.z + motion.approach_above_m)),
        motion.free_speed_m_s,
    )
    yield from move_to(context, tool, motion.approach_speed_m_s)
    height = float(seen.tip.tip[2]) - tool.z
    context.belief.tips.pop(end, None)
    yield from close_on_wire(
        context, Grip(end=end, distance=distance, height=height, flip=flip, tool=tool)
    )
    context.device.magazine.open_magazine(end)
    if context.belief.ends[end.other] is not EndState.LOOSE:
        # It has nothing more to keep, and the wire could hang on it.
        context.device.magazine.lower_fork()
    context.report(f"lifting end {end.value}", first + 0.9 * (last - first))
    lifted = max(motion.carry_z_m, tool.z + motion.lift_above_m)
    yield from move_to(context, context.commanded.at(z=lifted), motion.lift_speed_m_s)
    check_grip(context)


def grasp_distance(context: RobotContext, end: WireEnd) -> float:
    """Return where an end is grasped, from its tip [m]: a connector at its body's rear."""
    connector = context.wire.connector_at(end)
    if connector is None:
        return _wire_grasp_distance(context, end)
    return connector.length - context.fingers.width / 2


def inside_terminal(context: RobotContext, end: WireEnd) -> float:
    """Return how much of the live wire is inside the terminal that an end belongs in [m]."""
    connector = context.wire.connector_at(end)
    if connector is not None:
        return connector.pin_length
    component_id, terminal_id = context.wire.goes_to(end)
    return context.panel.component(component_id).terminal(terminal_id).depth


def _wire_grasp_distance(context: RobotContext, end: WireEnd) -> float:
    """Return where an end without a connector is grasped [m]; it may have slid in its clips."""
    belief, seen = context.belief, context.belief.tips.get(end)
    if not belief.by_magazine:
        return GRASP_DISTANCE_M
    if end in belief.picked_at or seen is None:
        return GRASP_M
    out = np.array([math.cos(seen.out_yaw), math.sin(seen.out_yaw)])
    slid = float((belief.expected[end] - seen.tip)[:2] @ out)
    return grasp_before_clips(slid, context.fingers.width)


def _check_room(context: RobotContext, seen: GraspObservation) -> None:
    """Raise UNREACHABLE when a row leaves no room for a finger beside the wire."""
    tool = context.parameters.tool
    if context.belief.feed is None or context.belief.by_magazine:
        return
    channel = context.panel.channel(context.belief.feed.channel_id)
    aside = abs(float(seen.point[0] - context.panel.world_from_panel.position[0]) - channel.x)
    room = channel.width / 2 - aside
    if 0 < room < tool.finger_room_m:
        raise AbilityError(
            Code.UNREACHABLE,
            f"the end lies {room * 1e3:.0f} mm from the row beside channel {channel.id!r}; a "
            "finger "
            f"needs {tool.finger_room_m * 1e3:.0f} mm; feed the wire again",
        )


def _grasp_pose(
    context: RobotContext, seen: GraspObservation, distance: float, socket: Pose
) -> tuple[ToolPose, float]:
    arm, (x, y, z) = context.arm, (float(v) for v in seen.point)
    into = unit_x(socket)
    then = socket.position - into * distance
    flip = choose_flip(
        arm, (x, y), seen.tip_yaw, (float(then[0]), float(then[1])), then_tip_yaw=socket.yaw
    )
    yaw = float(wrap_angle(seen.tip_yaw - flip))
    return ToolPose(
        x, y, max(z, arm.fingers.below + context.parameters.tool.floor_clearance_m), yaw
    ), flip


def close_on_wire(context: RobotContext, grip: Grip) -> Steps[None]:
    """Close the fingers until they press on an end; raises GRASP_MISSED, the hand open again."""
    wire = context.wire
    connector = wire.connector_at(grip.end)
    thickness = wire.diameter if connector is None else connector.body_width
    yield from close_fingers_on(context, thickness)
    context.belief.grip = grip
    context.belief.engaged = None
    context.belief.picked_at[grip.end] = grip


def close_fingers_on(context: RobotContext, thickness: float) -> Steps[None]:
    """Close the fingers until they press on what is so thick [m].

    Raises:
        AbilityError: GRASP_MISSED, the hand open again, and lifted.
    """
    tool = context.parameters.tool
    wire_id = context.wire.id
    context.empty_force = context.free_force = context.device.arm.force
    context.close_fingers(thickness)
    gap = yield from fingers_still(context)
    if gap > thickness + tool.blocked_m:
        yield from _open_and_rise(context)
        raise AbilityError(
            Code.GRASP_MISSED,
            f"the fingers met something {gap * 1e3:.1f} mm apart beside {wire_id!r}, which is "
            f"{thickness * 1e3:.1f} mm thick; detect it again, clear what stands beside it",
        )
    if grips_nothing(context, thickness):
        yield from _open_and_rise(context)
        raise AbilityError(
            Code.GRASP_MISSED,
            f"the fingers closed to {gap * 1e3:.1f} mm on {thickness * 1e3:.1f} mm of {wire_id!r}: "
            "it is not between them; detect it again",
        )


def _open_and_rise(context: RobotContext) -> Steps[None]:
    tool = context.parameters.tool
    context.drive_fingers(tool.open_m)
    yield from fingers_still(context)
    yield from rise(context)


def grips_nothing(context: RobotContext, thickness: float) -> bool:
    """Return whether closed fingers have missed what is so thick [m]."""
    return context.device.gripper.gap < context.parameters.tool.missed_share * thickness


def holds(context: RobotContext) -> bool:
    """Return whether the fingers press on something: they stay where they are when it slips out."""
    return context.device.gripper.load > context.parameters.tool.held_load_n


def check_grip(context: RobotContext) -> None:
    """Raise GRASP_SLIPPED, and note an empty hand, when nothing presses the fingers apart."""
    if context.belief.grip is not None and not holds(context):
        end = context.belief.grip.end
        context.belief.grip = None
        raise AbilityError(
            Code.GRASP_SLIPPED,
            f"end {end.value} of {context.wire.id!r} slipped out of the fingers, which feel "
            f"{context.device.gripper.load:.1f} N; detect it again",
        )


def release(context: RobotContext, opening: float) -> Steps[None]:
    """Open the fingers a little, leave the wire where it is, and lift the hand clear of it."""
    motion = context.parameters.motion
    yield from open_fingers(context, opening)
    clear = context.commanded.z + motion.clear_of_wire_m
    yield from move_to(context, context.commanded.at(z=clear), motion.clear_speed_m_s)


def open_fingers(context: RobotContext, opening: float) -> Steps[None]:
    """Open the fingers a little, slowly.

    A bent wire leans on a pad, and one that is thrown aside pulls at its fixed end.
    """
    tool = context.parameters.tool
    start = context.device.gripper.gap / 2
    context.belief.grip = None
    context.belief.engaged = None
    for tick in range(1, math.ceil(opening / tool.open_speed_m_s / context.tick_s) + 1):
        context.drive_fingers(start + min(opening, tick * tool.open_speed_m_s * context.tick_s))
        yield


def _room_beside(context: RobotContext, terminal: TerminalKey) -> float:
    """Return how far a finger may open beside a wire in a terminal, its neighbours wired [m]."""
    tool = context.parameters.tool
    own, half = context.panel.panel_from_socket(*terminal), context.wire.radius
    rooms = [tool.open_m]
    for wire in context.panel.wires:
        for end in WireEnd:
            place = context.panel.panel_from_socket(*wire.goes_to(end)).position
            away, aside, _ = np.abs(own.inverse().apply(place))
            if (
                away < context.parameters.terminal.neighbour_within_m
                and 0 < aside < 2 * tool.open_m
            ):
                taken = wire.radius + half + context.fingers.outer_m + tool.clear_of_neighbours_m
                rooms.append(float(aside) - taken)
    return max(tool.least_opening_m, min(rooms))


def opening_beside_neighbours(context: RobotContext, terminal: TerminalKey) -> float:
    """Return how far from the middle each finger goes down on a wire at its terminal [m]."""
    return min(
        context.parameters.tool.open_m, context.wire.radius + _room_beside(context, terminal)
    )


def release_fixed(context: RobotContext, end: WireEnd, terminal: TerminalKey) -> Steps[None]:
    """Note that a terminal holds the end in the hand, release it, and lift the hand off."""
    motion = context.parameters.motion
    belief = context.belief
    if belief.feed is not None and belief.occupied.get(terminal) != (belief.feed.wire_id, end):
        belief.seat(end, terminal)
    belief.ends[end] = EndState.FIXED
    context.report("releasing", 0.8)
    opening = min(context.parameters.tool.release_opening_m, _room_beside(context, terminal))
    yield from release(context, opening)
    yield from move_to(
        context, context.commanded.at(z=motion.travel_z_m), motion.approach_speed_m_s * 2
    )
    if belief.ends[end.other] is EndState.LOOSE and end.other in belief.expected:
        belief.tips.pop(end.other, None)
