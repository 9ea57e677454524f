"""Motions of the arm, as steps of an ability."""

from __future__ import annotations

import math

import numpy as np

from remodel_sim.abilities.station import Station, Steps
from remodel_sim.core.arm import ToolPose, canonical_yaw, joints_for, tool_of
from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose, wrap_angle
from remodel_sim.core.motion import PEAK_OVER_MEAN, Line
from remodel_sim.physics.plant import PARKED

FREE_SPEED = 0.60  # [m/s], hand empty and high
CARRY_SPEED = 0.30  # with a wire in the hand
APPROACH_SPEED = 0.25  # near things
JOINT_SPEED = 2.0  # [rad/s]; the Panda's joints 1 to 4 allow 2.17
# High enough for the fingers to pass over components, 45 mm high, with a wire in the grip.
TRAVEL_Z = 0.10
# Low enough that a carried wire stays between the rows.
CARRY_Z = 0.028
HAND_OPEN_M = 0.012
TRACKING_TOLERANCE_M = 0.003
# The servo lags by up to 8 mm at full speed; more means that something is in the way.
MAX_LAG_M = 0.015


def move_to(station: Station, target: ToolPose, speed: float) -> Steps[None]:
    """Move the tool in a straight line.

    Raises UNREACHABLE before it starts, MOTION_FAULT when it does not arrive.
    """
    line = Line(_canonical(station.commanded), _canonical(target), speed)
    line.check_reach()
    for tick in range(1, math.ceil(line.duration / station.tick_s) + 1):
        station.drive(line.at(tick * station.tick_s))
        yield
        _check_lag(station)
    station.drive(line.end)
    yield
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
    start, end = joints_for(station.commanded), joints_for(target)
    farthest = float(np.abs(end - start).max())
    ticks = math.ceil(PEAK_OVER_MEAN * farthest / JOINT_SPEED / station.tick_s)
    for tick in range(1, ticks + 1):
        t = tick / ticks
        station.drive_joints(start + t**3 * (10 - 15 * t + 6 * t * t) * (end - start))
        yield
    station.commanded = tool_of(end)


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


def park(station: Station) -> Steps[None]:
    """Take the empty hand out of the overhead camera's picture."""
    if station.commanded != PARKED:
        yield from clear_hand(station)
        yield from swing_to(station, PARKED)
        station.commanded = PARKED


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
    at: tuple[float, float], tip_yaw: float, then_at: tuple[float, float], then_tip_yaw: float
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
        first = canonical_yaw(*at, tip_yaw - flip)
        second = canonical_yaw(*then_at, then_tip_yaw - flip)
        if first is None or second is None or abs(second - first - turn) > 0.5:
            continue
        q7 = [math.atan2(at[1], at[0]) + math.pi / 4 - first]
        q7.append(math.atan2(then_at[1], then_at[0]) + math.pi / 4 - second)
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


def nearest_hand_yaw(x: float, y: float, yaw: float, near: float) -> float:
    """Return `yaw`, or that turned by pi, whichever joint 7 reaches with less turning."""
    options = [canonical_yaw(x, y, yaw + turn) for turn in (0.0, math.pi)]
    reachable = [option for option in options if option is not None]
    return min(reachable, key=lambda option: abs(option - near), default=yaw)


def _canonical(tool: ToolPose) -> ToolPose:
    yaw = canonical_yaw(tool.x, tool.y, tool.yaw)
    return tool if yaw is None else ToolPose(tool.x, tool.y, tool.z, yaw)
