"""Grasp a loose end by friction, as steps of an ability."""

from __future__ import annotations

import math

import numpy as np

from remodel_skills.belief_state import EndState, Grip
from remodel_skills.primitives.motions import (
    APPROACH_SPEED,
    CARRY_Z,
    FREE_SPEED,
    HAND_OPEN_M,
    TRAVEL_Z,
    choose_flip,
    move_to,
    rise,
    wait,
)
from remodel_skills.primitives.observation.observing import GraspObservation, observe_end
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.cell.magazine import GRASP_M, grasp_before_clips
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose, wrap_angle
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.openings import TerminalKey
from remodel_work.panel import WireEnd, unit_x
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.kinematics import Kinematics

# The pads stop so far above the plate.
FLOOR_CLEARANCE_M = 0.0003
CLOSE_TIMEOUT_S = 1.5
# A gap of less than this share of the wire's or connector's width means that it is not there; one
# that is so much wider [m], that the fingers met something else.
MISSED_SHARE, BLOCKED_M = 0.45, 0.003
# Fingers that hold a wire feel tens of newtons; without one, nothing.
HELD_LOAD_N = 4.0
APPROACH_Z = 0.06
# The hand comes down to an end in the magazine from so far above it, and lifts it by so much [m].
APPROACH_M = 0.04
LIFT_M = 0.02
LIFT_SPEED = 0.05  # [m/s]; the heavier a wire is made (README), the more a jerk pulls at the grip
OPEN_SPEED = 0.015  # [m/s]
CLEAR_SPEED = 0.05  # [m/s]
CLEAR_OF_WIRE_M = 0.02
# Of an end that is fixed; no wider: the pad on the side to which it bends would push it there.
RELEASE_OPENING_M = 0.0025
# Fingers open by so much at least, and keep so far from the wires of neighbouring terminals, whose
# openings are within so much of the own one along it [m].
LEAST_OPENING_M = 0.0006
CLEAR_OF_NEIGHBOURS_M = 0.0005
BESIDE_M = 0.02
# An open finger reaches so far to the side of the wire.
FINGER_ROOM_M = HAND_OPEN_M + 0.012


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
    distance = distance or grasp_distance(context, end)
    first, last = shares
    context.report(f"searching for end {end.value} of {context.wire.id}", first)
    seen = yield from observe_end(context, end, distance)
    context.report(f"grasping end {end.value}", first + 0.6 * (last - first))
    _check_room(context, seen)
    tool, flip = _grasp_pose(context.arm, seen, distance, socket)
    yield from move_to(context, tool.at(z=context.commanded.z), FREE_SPEED)
    context.drive_fingers(HAND_OPEN_M)
    yield from move_to(context, tool.at(z=max(APPROACH_Z, tool.z + APPROACH_M)), FREE_SPEED)
    yield from move_to(context, tool, APPROACH_SPEED)
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
    lifted = max(CARRY_Z, tool.z + LIFT_M)
    yield from move_to(context, context.commanded.at(z=lifted), LIFT_SPEED)
    check_grip(context)


def grasp_distance(context: RobotContext, end: WireEnd) -> float:
    """Return where an end is grasped, from its tip [m]: a connector at its body's rear."""
    connector = context.wire.connector_at(end)
    if connector is None:
        return _wire_grasp_distance(context, end)
    return connector.length - context.fingers.width / 2


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
    if context.belief.feed is None or context.belief.by_magazine:
        return
    channel = context.panel.channel(context.belief.feed.channel_id)
    aside = abs(float(seen.point[0] - context.panel.world_from_panel.position[0]) - channel.x)
    room = channel.width / 2 - aside
    if 0 < room < FINGER_ROOM_M:
        raise AbilityError(
            Code.UNREACHABLE,
            f"the end lies {room * 1e3:.0f} mm from the row beside channel {channel.id!r}; a "
            "finger "
            f"needs {FINGER_ROOM_M * 1e3:.0f} mm; feed the wire again",
        )


def _grasp_pose(
    arm: Kinematics, seen: GraspObservation, distance: float, socket: Pose
) -> tuple[ToolPose, float]:
    x, y, z = (float(v) for v in seen.point)
    into = unit_x(socket)
    then = socket.position - into * distance
    flip = choose_flip(
        arm, (x, y), seen.tip_yaw, (float(then[0]), float(then[1])), then_tip_yaw=socket.yaw
    )
    yaw = float(wrap_angle(seen.tip_yaw - flip))
    return ToolPose(x, y, max(z, arm.fingers.below + FLOOR_CLEARANCE_M), yaw), flip


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
    wire_id = context.wire.id
    context.empty_force = context.free_force = context.device.arm.force
    context.close_fingers(thickness)
    gap = math.inf
    for _ in range(math.ceil(CLOSE_TIMEOUT_S / context.tick_s)):
        yield
        before, gap = gap, context.device.gripper.gap
        if abs(before - gap) < 1e-5:
            break
    if gap > thickness + BLOCKED_M:
        yield from _open_and_rise(context)
        raise AbilityError(
            Code.GRASP_MISSED,
            f"the fingers met something {gap * 1e3:.1f} mm apart beside {wire_id!r}, which is "
            f"{thickness * 1e3:.1f} mm thick; detect it again, clear what stands beside it",
        )
    if grips_nothing(gap, thickness):
        yield from _open_and_rise(context)
        raise AbilityError(
            Code.GRASP_MISSED,
            f"the fingers closed to {gap * 1e3:.1f} mm on {thickness * 1e3:.1f} mm of {wire_id!r}: "
            "it is not between them; detect it again",
        )


def _open_and_rise(context: RobotContext) -> Steps[None]:
    context.drive_fingers(HAND_OPEN_M)
    yield from wait(context, 0.2)
    yield from rise(context)


def grips_nothing(gap: float, thickness: float) -> bool:
    """Return whether closed fingers with a gap [m] have missed what is so thick [m]."""
    return gap < MISSED_SHARE * thickness


def holds(context: RobotContext) -> bool:
    """Return whether the fingers press on something: they stay where they are when it slips out."""
    return context.device.gripper.load > HELD_LOAD_N


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
    yield from open_fingers(context, opening)
    clear = context.commanded.z + CLEAR_OF_WIRE_M
    yield from move_to(context, context.commanded.at(z=clear), CLEAR_SPEED)


def open_fingers(context: RobotContext, opening: float) -> Steps[None]:
    """Open the fingers a little, slowly.

    A bent wire leans on a pad, and one that is thrown aside pulls at its fixed end.
    """
    start = context.device.gripper.gap / 2
    context.belief.grip = None
    context.belief.engaged = None
    for tick in range(1, math.ceil(opening / OPEN_SPEED / context.tick_s) + 1):
        context.drive_fingers(start + min(opening, tick * OPEN_SPEED * context.tick_s))
        yield


def _room_beside(context: RobotContext, terminal: TerminalKey) -> float:
    """Return how far a finger may open beside a wire in a terminal, its neighbours wired [m]."""
    own, half = context.panel.panel_from_socket(*terminal), context.wire.radius
    rooms = [HAND_OPEN_M]
    for wire in context.panel.wires:
        for end in WireEnd:
            place = context.panel.panel_from_socket(*wire.goes_to(end)).position
            away, aside, _ = np.abs(own.inverse().apply(place))
            if away < BESIDE_M and 0 < aside < 2 * HAND_OPEN_M:
                taken = wire.radius + half + context.fingers.outer_m + CLEAR_OF_NEIGHBOURS_M
                rooms.append(float(aside) - taken)
    return max(LEAST_OPENING_M, min(rooms))


def opening_beside_neighbours(context: RobotContext, terminal: TerminalKey) -> float:
    """Return how far from the middle each finger goes down on a wire at its terminal [m]."""
    return min(HAND_OPEN_M, context.wire.radius + _room_beside(context, terminal))


def release_fixed(context: RobotContext, end: WireEnd, terminal: TerminalKey) -> Steps[None]:
    """Note that a terminal holds the end in the hand, release it, and lift the hand off."""
    belief = context.belief
    if belief.feed is not None and belief.occupied.get(terminal) != (belief.feed.wire_id, end):
        belief.seat(end, terminal)
    belief.ends[end] = EndState.FIXED
    context.report("releasing", 0.8)
    opening = min(RELEASE_OPENING_M, _room_beside(context, terminal))
    yield from release(context, opening)
    yield from move_to(context, context.commanded.at(z=TRAVEL_Z), APPROACH_SPEED * 2)
    if belief.ends[end.other] is EndState.LOOSE and end.other in belief.expected:
        belief.tips.pop(end.other, None)
