"""Motions of the arm, as steps of an ability."""

from __future__ import annotations

import math

import numpy as np

from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array, Pose, wrap_angle
from remodel_sim.core.robot.arm import Arm, ToolPose
from remodel_sim.core.robot.motion import PEAK_OVER_MEAN, Line
from remodel_states.core.codes import Code

FREE_SPEED = 0.60  # [m/s], hand empty and high
CARRY_SPEED = 0.30  # with a wire in the hand
APPROACH_SPEED = 0.25  # near things
JOINT_SPEED = 2.0  # [rad/s]; the Panda's joints 1 to 4 allow 2.17
# High enough for the fingers to pass over components, 45 mm high, with a wire in the grip.
TRAVEL_Z = 0.10
# Low enough that a carried wire stays between the rows.
CARRY_Z = 0.028
HAND_OPEN_M = 0.012
# A path through joint space is checked this far apart [rad].
CHECK_STEP_RAD = 0.1
# Another robot is waited for so long, and looked after so often [s].
PATIENCE_S = 60.0
WAIT_S = 0.1
TRACKING_TOLERANCE_M = 0.003
# The servo lags by up to 8 mm at full speed; more means that something is in the way.
MAX_LAG_M = 0.015


def move_to(station: Station, target: ToolPose, speed: float) -> Steps[None]:
    """Move the tool in a straight line.

    Raises UNREACHABLE before it starts, MOTION_FAULT when it does not arrive.
    """
    line = Line(_canonical(station, station.commanded), _canonical(station, target), speed)
    postures = line.postures(station.arm)
    yield from clear_way(station, postures)
    for tick in range(1, math.ceil(line.duration / station.tick_s) + 1):
        station.follow(line.at(tick * station.tick_s))
        yield
        _check_lag(station)
    station.follow(line.end)
    yield
    station.stand()
    check_tracking(station)


def _check_lag(station: Station) -> None:
    """Stop the arm and raise MOTION_FAULT when something holds it up."""
    sent, tool = station.commanded, station.tool
    lag = float(np.linalg.norm(tool.position - sent.position))
    if lag > MAX_LAG_M:
        station.drive(tool)
        raise AbilityError(
            Code.MOTION_FAULT,
            f"the tool is held up at {tool}, {lag * 1e3:.0f} mm behind; look for a collision",
        )


def check_tracking(station: Station) -> None:
    """Raise MOTION_FAULT when the arm is not where it was sent."""
    away = float(np.linalg.norm(station.tool.position - station.commanded.position))
    if away > TRACKING_TOLERANCE_M:
        raise AbilityError(
            Code.MOTION_FAULT,
            f"the tool stands {away * 1e3:.1f} mm from {station.commanded}; look for a collision",
        )


def swing_to(station: Station, target: ToolPose) -> Steps[None]:
    """Move the empty hand, high up, through joint space; raises UNREACHABLE before it starts."""
    start, end = station.arm.joints_for(station.commanded), station.arm.joints_for(target)
    farthest = float(np.abs(end - start).max())
    parts = math.ceil(farthest / CHECK_STEP_RAD) + 1
    yield from clear_way(station, np.linspace(start, end, parts + 1))
    ticks = math.ceil(PEAK_OVER_MEAN * farthest / JOINT_SPEED / station.tick_s)
    for tick in range(1, ticks + 1):
        t = tick / ticks
        station.drive_joints(start + t**3 * (10 - 15 * t + 6 * t * t) * (end - start))
        yield
    station.commanded = station.arm.tool_of(end)
    station.stand()


def wait(station: Station, seconds: float) -> Steps[None]:
    """Let time pass."""
    for _ in range(math.ceil(seconds / station.tick_s)):
        yield


def held_tool(station: Station, pose: Pose) -> ToolPose:
    """Return the tool pose that points the held wire's tip along a pose's x axis."""
    x, y, z = (float(v) for v in pose.position)
    flip = station.book.grip.flip if station.book.grip is not None else 0.0
    return ToolPose(x, y, z, pose.yaw - (0.0 if math.isclose(flip, 0.0) else flip))


def rise(station: Station, z: float = TRAVEL_Z) -> Steps[None]:
    """Lift the tool straight up to a height, unless it is higher."""
    if station.commanded.z < z:
        yield from move_to(station, station.commanded.at(z=z), FREE_SPEED)


def clear_hand(station: Station) -> Steps[None]:
    """Open the empty hand and lift it: an ability that was stopped may have left it anywhere."""
    if station.fingers_open_to < HAND_OPEN_M:
        station.drive_fingers(HAND_OPEN_M)
        yield from wait(station, 0.2)
    yield from rise(station)


def clear_way(station: Station, postures: Array) -> Steps[None]:
    """Wait until no other robot is in the way of a path, (n, 7) [rad], and claim its room.

    A robot that does nothing and holds nothing is sent home.

    Raises:
        AbilityError: ROBOT_IN_THE_WAY when it holds something, or waits for this one, or does not
            make way in time.
    """
    for _ in range(math.ceil(PATIENCE_S / WAIT_S)):
        other = station.claim(postures)
        if other is None:
            station.wait_for(None)
            return
        _check_makes_way(station, other)
        station.wait_for(other)
        if other.busy:
            yield from wait(station, WAIT_S)
        else:
            yield from send_home(other)
    raise AbilityError(
        Code.ROBOT_IN_THE_WAY,
        f"{other.name} has been in the way of {station.name} for {PATIENCE_S:.0f} s: it does "
        f"{other.progress.message!r}; wait for it or cancel it",
    )


def _check_makes_way(station: Station, other: Station) -> None:
    if other.waits_for(station):
        raise AbilityError(
            Code.ROBOT_IN_THE_WAY,
            f"{station.name} and {other.name} are in each other's way; {station.name} gives up: "
            "try again when the other is done",
        )
    if not other.busy and (other.book.grip is not None or other.commanded == other.home):
        raise AbilityError(
            Code.ROBOT_IN_THE_WAY,
            f"{other.name} stands at {other.commanded}, in the way of {station.name}; place what "
            "it holds, or go another way",
        )


def send_home(other: Station) -> Steps[None]:
    """Take the empty hand of a robot that does nothing home."""
    other.begin()
    other.report("making way", 0.0)
    try:
        yield from _go_home(other)
    finally:
        other.end()


def park(station: Station) -> Steps[None]:
    """Take the empty hand out of the overhead camera's picture, and idle robots' as well."""
    for other in station.peers:
        if not other.busy and other.book.grip is None and other.commanded != other.home:
            yield from send_home(other)
    yield from _go_home(station)


def _go_home(station: Station) -> Steps[None]:
    if station.commanded != station.home:
        yield from clear_hand(station)
        yield from swing_to(station, station.home)
        station.commanded = station.home


def disengage(station: Station) -> Steps[None]:
    """Draw the held end straight out of the mouth that it is in front of or in."""
    socket = station.book.engaged
    if socket is None or station.book.grip is None:
        return
    into = socket.rotation[:, 0]
    grip, at = station.book.grip, station.commanded
    ahead = float((at.position - socket.position) @ into) + grip.distance
    back = max(0.0, ahead + CLEAR_OF_MOUTH_M)
    target = ToolPose(at.x - back * into[0], at.y - back * into[1], at.z, at.yaw)
    yield from move_to(station, target, APPROACH_SPEED / 2)
    station.book.engaged = None


CLEAR_OF_MOUTH_M = 0.008


def choose_flip(
    arm: Arm,
    at: tuple[float, float],
    tip_yaw: float,
    then_at: tuple[float, float],
    then_tip_yaw: float,
) -> float:
    """Return how to hold a wire, tip along the hand's x axis (0) or against it (pi).

    The hand grasps at one place and turns the wire to another direction at a second one; joint 7
    must reach both, and turn the short way between them. Of two ways the one further from joint 7's
    limits is taken.

    Raises:
        AbilityError: UNREACHABLE.
    """
    turn = wrap_angle(then_tip_yaw - tip_yaw)
    best: tuple[float, float] | None = None
    for flip in (0.0, math.pi):
        first = arm.canonical_yaw(*at, tip_yaw - flip)
        second = arm.canonical_yaw(*then_at, then_tip_yaw - flip)
        if first is None or second is None or abs(second - first - turn) > 0.5:
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


def nearest_hand_yaw(arm: Arm, x: float, y: float, yaw: float, near: float) -> float:
    """Return `yaw`, or that turned by pi, whichever joint 7 reaches with less turning."""
    options = [arm.canonical_yaw(x, y, yaw + turn) for turn in (0.0, math.pi)]
    reachable = [option for option in options if option is not None]
    return min(reachable, key=lambda option: abs(option - near), default=yaw)


def _canonical(station: Station, tool: ToolPose) -> ToolPose:
    yaw = station.arm.canonical_yaw(tool.x, tool.y, tool.yaw)
    return tool if yaw is None else ToolPose(tool.x, tool.y, tool.z, yaw)
