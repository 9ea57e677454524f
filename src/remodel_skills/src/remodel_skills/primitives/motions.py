"""Motions of the arm, as steps of an ability."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from itertools import pairwise

import numpy as np

from remodel_skills.motion import PEAK_OVER_MEAN, Line, progress
from remodel_skills.robot_context import RobotContext, Steps
from remodel_skills.space import Touch
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.layout import STANDOFF_M
from remodel_work.robot.arm import Kinematics, ToolPose

NOTHING: Set[str] = frozenset()


def move_to(
    context: RobotContext, target: ToolPose, speed: float, allowed: Set[str] = NOTHING
) -> Steps[None]:
    """Move the tool in a straight line, or over what it would touch on it.

    Args:
        context: of the robot that moves.
        target: where to.
        speed: peak speed of the tool centre [m/s].
        allowed: names of obstacles that the motion may touch, see `remodel_work/obstacles.py`.

    Raises:
        AbilityError: UNREACHABLE before it starts, MOTION_FAULT when it does not arrive.
    """
    for line in _clear_lines(context, target, speed, allowed):
        yield from clear_path(context, line.postures(context.arm))
        for tick in range(1, math.ceil(line.duration / context.tick_s) + 1):
            context.follow(line.at(tick * context.tick_s))
            yield
            check_lag(context, line.at((tick - context.lead_ticks) * context.tick_s))
        context.follow(line.end)
        yield from wait_to_follow(context)
        context.space.stand(context.commanded)
        check_tracking(context)


def straight_line(
    context: RobotContext, target: ToolPose, speed: float, allowed: Set[str] = NOTHING
) -> Line:
    """Return the straight line to a tool pose; raises UNREACHABLE when it would touch something."""
    line = _line_to(context, target, speed)
    touch = _touch_on(context, line, allowed)
    if touch is not None:
        raise _blocked(touch, target)
    return line


def is_free(
    context: RobotContext,
    target: ToolPose,
    allowed: Set[str] = NOTHING,
    start: ToolPose | None = None,
) -> bool:
    """Return whether the straight line to a tool pose touches nothing else; raises UNREACHABLE.

    It begins where the tool is, unless at `start`.
    """
    line = _line_to(context, target, context.parameters.motion.approach_speed_m_s, start)
    return _touch_on(context, line, allowed) is None


def _line_to(
    context: RobotContext, target: ToolPose, speed: float, start: ToolPose | None = None
) -> Line:
    start = canonical(context, context.commanded if start is None else start)
    end = canonical(context, target)
    return Line(start, end, speed, context.parameters.motion).paced(context.arm)


def _clear_lines(
    context: RobotContext, target: ToolPose, speed: float, allowed: Set[str]
) -> list[Line]:
    """Return the lines of a motion that touches nothing; raises UNREACHABLE."""
    arm, start, motion = context.arm, context.commanded, context.parameters.motion
    turn_rate = float(arm.speeds[-1]) if context.belief.grip is None else None

    def line(first: ToolPose, second: ToolPose) -> Line:
        ends = canonical(context, first), canonical(context, second)
        return Line(*ends, speed, motion, turn_rate).paced(arm)

    direct = line(start, target)
    touch = _touch_on(context, direct, allowed)
    if touch is None:
        return [direct]
    for height in motion.lifts_z_m:
        if height <= max(start.z, target.z):
            continue
        over = start.at(z=height), target.at(z=height)
        try:
            lines = [line(start, over[0]), line(*over), line(over[1], target)]
            if all(_touch_on(context, part, allowed) is None for part in lines):
                return lines
        except AbilityError as error:
            if error.code is not Code.UNREACHABLE:
                raise
    raise _blocked(touch, target, ", nor one over it,")


def _touch_on(context: RobotContext, line: Line, allowed: Set[str]) -> Touch | None:
    length = line.distance + context.parameters.tool.hand_corner_m * abs(
        line.end.yaw - line.start.yaw
    )
    return context.scene.first_touch(line.between, length, allowed)


def _blocked(touch: Touch, target: ToolPose, nor_over: str = "") -> AbilityError:
    return AbilityError(
        Code.UNREACHABLE,
        f"{touch}: no straight path to {target}{nor_over} is free; move what is in the way, or "
        "approach from elsewhere",
    )


def wait_to_follow(context: RobotContext) -> Steps[None]:
    """Wait until the arm may be where it was sent: a tick, and by how much commands lead."""
    for _ in range(1 + context.lead_ticks):
        yield


def check_lag(context: RobotContext, sent: ToolPose) -> None:
    """Stop the arm and raise MOTION_FAULT when something keeps it from where it was to be now."""
    tool = context.device.arm.tool
    lag = float(np.linalg.norm(tool.position - sent.position))
    if lag > context.parameters.motion.most_lag_m:
        context.follow(tool)
        raise AbilityError(
            Code.MOTION_FAULT,
            f"the tool is held up at {tool}, {lag * 1e3:.0f} mm behind; check for a collision",
        )


def check_tracking(context: RobotContext) -> None:
    """Raise MOTION_FAULT when the arm is not where it was sent."""
    away = float(np.linalg.norm(context.device.arm.tool.position - context.commanded.position))
    if away > context.parameters.motion.tracking_tolerance_m:
        raise AbilityError(
            Code.MOTION_FAULT,
            f"the tool stands {away * 1e3:.1f} mm from {context.commanded}; check for a collision",
        )


def swing_to(context: RobotContext, target: ToolPose) -> Steps[None]:
    """Move the empty hand, high up, past other robots; raises UNREACHABLE before it starts."""
    for leg in past_robots(context, target) or (target,):
        yield from _swing(context, leg)


def past_robots(context: RobotContext, target: ToolPose) -> tuple[ToolPose, ...]:
    """Return legs to a tool pose, over corners where a robot stands in the direct way.

    There are none where robots stand in all ways.
    """
    here, arm = context.commanded, context.arm
    for legs in _ways(here, target, context.parameters.motion.around_m):
        if not all(arm.reaches(leg) for leg in legs):
            continue
        stops = [arm.joints_for(leg) for leg in (here, *legs)]
        if all(context.space.has_way(_through(context, *pair)) for pair in pairwise(stops)):
            return legs
    return ()


def _ways(
    here: ToolPose, target: ToolPose, around_m: Sequence[float]
) -> Iterator[tuple[ToolPose, ...]]:
    """Yield legs to a tool pose: straight, over one corner, or around what stands between.

    Around it is so far beyond where the hand begins and where it ends [m].
    """
    yield (target,)
    for corner in (replace(target, x=here.x, z=here.z), replace(target, y=here.y, z=here.z)):
        yield corner, target
    for away in around_m:
        for x in (max(here.x, target.x) + away, min(here.x, target.x) - away):
            yield replace(target, x=x, y=here.y, z=here.z), replace(target, x=x, z=here.z), target
        for y in (max(here.y, target.y) + away, min(here.y, target.y) - away):
            yield replace(target, x=here.x, y=y, z=here.z), replace(target, y=y, z=here.z), target


def _through(context: RobotContext, start: Array, end: Array) -> Array:
    """Return postures between two, (n, joints), as far apart as they are checked."""
    step_rad = context.parameters.motion.joint_check_step_rad
    return np.linspace(start, end, math.ceil(np.abs(end - start).max() / step_rad) + 2)


def _swing(context: RobotContext, target: ToolPose) -> Steps[None]:
    """Move the empty hand, high up, through joint space, or straight over what is in its way.

    An arm on an axis goes straight: a posture that its axis's rule does not give has no tool pose
    to resume from when it is stopped.
    """
    motion = context.parameters.motion
    if context.arm.axis is not None:
        yield from move_to(context, target, motion.free_speed_m_s)
        return
    start = context.arm.joints_for(context.commanded)
    end = context.arm.joints_for(canonical(context, target))
    farthest = float(np.abs(end - start).max())
    touch = context.scene.first_touch(
        lambda share: context.arm.tool_of(start + share * (end - start)),
        context.parameters.tool.arm_reach_m * farthest,
        NOTHING,
    )
    if touch is not None:
        yield from move_to(context, target, motion.free_speed_m_s)
        return
    yield from clear_path(context, _through(context, start, end))
    seconds = PEAK_OVER_MEAN * float((np.abs(end - start) / context.arm.speeds).max())
    ticks = math.ceil(seconds / context.tick_s)
    for tick in range(1, ticks + 1):
        context.drive_joints(start + progress(tick / ticks) * (end - start))
        yield
    yield from wait(context, context.lead_ticks * context.tick_s)
    context.commanded = context.arm.tool_of(end)
    context.space.stand(context.commanded)


def wait(context: RobotContext, seconds: float) -> Steps[None]:
    """Wait for a time [s]."""
    for _ in range(math.ceil(seconds / context.tick_s)):
        yield


def fingers_still(context: RobotContext) -> Steps[float]:
    """Wait until the fingers are still, or have had their time; return the gap of the pads [m].

    Fingers that have not begun to move are not still yet: a real gripper begins late.
    """
    tool, gap, still_s = context.parameters.tool, context.device.gripper.gap, 0.0
    for _ in range(math.ceil(tool.close_timeout_s / context.tick_s)):
        yield
        before, gap = gap, context.device.gripper.gap
        still_s = still_s + context.tick_s if abs(before - gap) < tool.fingers_still_m else 0.0
        if still_s >= tool.fingers_still_s:
            break
    return gap


def held_tool(context: RobotContext, pose: Pose) -> ToolPose:
    """Return the tool pose that points the held wire's tip along a pose's x axis."""
    x, y, z = (float(v) for v in pose.position)
    flip = context.belief.grip.flip if context.belief.grip is not None else 0.0
    return ToolPose(x, y, z, pose.yaw - (0.0 if math.isclose(flip, 0.0) else flip))


def rise(context: RobotContext, z: float | None = None) -> Steps[None]:
    """Lift the tool straight up to a height, that of travel by default, unless it is higher."""
    motion = context.parameters.motion
    z = motion.travel_z_m if z is None else z
    if context.commanded.z < z:
        yield from move_to(context, context.commanded.at(z=z), motion.free_speed_m_s)


def clear_hand(context: RobotContext) -> Steps[None]:
    """Open the empty hand and lift it: an ability that was stopped may have left it anywhere."""
    tool = context.parameters.tool
    context.keeps_wire = False
    if context.fingers_open_to < tool.open_m:
        context.drive_fingers(tool.open_m)
        yield from fingers_still(context)
    yield from rise(context)


def clear_path(context: RobotContext, postures: Array) -> Steps[None]:
    """Wait until no other robot is in the way of a path, (n, joints), and claim its space.

    A robot that does nothing and holds nothing is sent home.

    Raises:
        AbilityError: ROBOT_IN_THE_WAY when it holds something, or waits for this one, or does not
            make way in time.
    """
    motion = context.parameters.motion
    for _ in range(math.ceil(motion.wait_limit_s / motion.wait_s)):
        name = context.space.claim(postures)
        if name is None:
            context.space.wait_for(None)
            return
        other = context.robots[name]
        _check_makes_way(context, other)
        context.space.wait_for(name)
        if other.busy:
            yield from wait(context, motion.wait_s)
        else:
            yield from send_home(other)
    raise AbilityError(
        Code.ROBOT_IN_THE_WAY,
        f"{name} has been in the way of {context.name} for {motion.wait_limit_s:.0f} s: "
        f"it does {other.progress.message!r}; wait for it or cancel it",
    )


def _check_makes_way(context: RobotContext, other: RobotContext) -> None:
    if other.space.waits_for(context.name):
        raise AbilityError(
            Code.ROBOT_IN_THE_WAY,
            f"{context.name} and {other.name} are in each other's way; {context.name} gives up: "
            "try again when the other is done",
        )
    if not other.busy and (other.belief.grip is not None or other.commanded == other.home):
        raise AbilityError(
            Code.ROBOT_IN_THE_WAY,
            f"{other.name} stands at {other.commanded}, in the way of {context.name}; place what "
            "it holds, or take another route",
        )


def send_home(other: RobotContext) -> Steps[None]:
    """Take the empty hand of a robot that does nothing home."""
    other.begin()
    other.report("making way", 0.0)
    try:
        yield from _go_home(other)
    finally:
        other.end()


def park(context: RobotContext) -> Steps[None]:
    """Take the empty hand out of the overhead camera's picture, and idle robots' as well."""
    for other in context.peers:
        if not other.busy and other.belief.grip is None and other.commanded != other.home:
            yield from send_home(other)
    yield from _go_home(context)


def _go_home(context: RobotContext) -> Steps[None]:
    if context.commanded != context.home:
        yield from clear_hand(context)
        yield from swing_to(context, context.home)
        context.commanded = context.home


def disengage(context: RobotContext) -> Steps[None]:
    """Pull the held end straight out of the opening that it is in or in front of."""
    socket = context.belief.engaged
    if socket is None or context.belief.grip is None:
        return
    into = socket.rotation[:, 0]
    grip, at = context.belief.grip, context.commanded
    ahead = float((at.position - socket.position) @ into) + grip.distance
    back = max(0.0, ahead + STANDOFF_M)
    yield from move_to(
        context, at.moved(into, -back), context.parameters.motion.approach_speed_m_s / 2
    )
    context.belief.engaged = None


def choose_flip(
    arm: Kinematics,
    at: tuple[float, float],
    tip_yaw: float,
    then_at: tuple[float, float],
    then_tip_yaw: float,
) -> float:
    """Return how to hold a wire, tip along the hand's x axis (0) or against it (pi).

    The hand grasps at one place and turns the wire to another direction at a second one; joint 7
    must reach both, and turn the short way between them. Of two possible holds it takes
    the one further from joint 7's limits.

    Raises:
        AbilityError: UNREACHABLE.
    """
    turn = wrap_angle(then_tip_yaw - tip_yaw)
    best: tuple[float, float] | None = None
    for flip in (0.0, math.pi):
        first = arm.canonical_yaw(*at, float(wrap_angle(tip_yaw - flip)))
        if first is None:
            continue
        second = arm.canonical_yaw(*then_at, first + turn)
        if second is None or abs(second - first - turn) > 0.5:
            continue
        q7 = [arm.last_joint(*at, first), arm.last_joint(*then_at, second)]
        cost = max(abs(q) for q in q7)
        if best is None or cost < best[0]:
            best = cost, flip
    if best is None:
        raise AbilityError(
            Code.UNREACHABLE,
            f"the hand cannot turn the wire from {math.degrees(tip_yaw):.0f} to "
            f"{math.degrees(then_tip_yaw):.0f} deg "
            f"between x {at[0]:.3f}, y {at[1]:.3f} m and x {then_at[0]:.3f}, y {then_at[1]:.3f} m",
        )
    return best[1]


def nearest_hand_yaw(arm: Kinematics, x: float, y: float, yaw: float, near: float) -> float:
    """Return `yaw`, or that turned by pi, whichever joint 7 reaches with less turning."""
    turns = (wrap_angle(yaw + turn - near) for turn in (0.0, math.pi))
    options = [arm.canonical_yaw(x, y, near + float(turn)) for turn in turns]
    reachable = [option for option in options if option is not None]
    return min(reachable, key=lambda option: abs(option - near), default=yaw)


def canonical(context: RobotContext, tool: ToolPose) -> ToolPose:
    """Return a tool pose with the yaw that the arm takes, of those that are a full turn apart.

    Of several the one as given; with a wire in the hand, which it would wind up, the nearest.
    """
    wanted = tool.yaw
    if context.belief.grip is not None:
        now = context.commanded.yaw
        wanted = now + float(wrap_angle(tool.yaw - now))
    yaw = context.arm.canonical_yaw(tool.x, tool.y, wanted)
    return tool if yaw is None else ToolPose(tool.x, tool.y, tool.z, yaw)
