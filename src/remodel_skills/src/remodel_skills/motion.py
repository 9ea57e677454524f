"""Straight tool motions, smooth in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from remodel_skills.parameters import MotionParameters
from remodel_work.geometry import Array
from remodel_work.robot.arm import Kinematics, ToolPose

# A minimum-jerk motion peaks at 15/8 of its mean speed.
PEAK_OVER_MEAN = 15.0 / 8.0
# Its acceleration peaks at 10 / sqrt(3) of its distance over the square of its time.
PEAK_ACCELERATION = 10.0 / math.sqrt(3.0)
# A ramp's speed is v u^2 (3 - 2 u) after a share u of its time: its acceleration peaks at 3/2 of
# the mean one.
RAMP_PEAK = 1.5


@dataclass(frozen=True)
class Timing:
    """How far a motion is after a time: at rest at both ends, and smooth.

    A short motion is one of minimum jerk (Flash and Hogan, The Coordination of Arm Movements,
    1985). That has its peak speed for a moment only: a long one speeds up along a ramp, keeps its
    peak speed, and slows down.

    Attributes:
        duration: of the motion [s].
        ramp: how long it speeds up, and slows down [s]; None: it is one of minimum jerk.
    """

    duration: float
    ramp: float | None = None

    def progress(self, elapsed: float) -> float:
        """Return the share of the motion that is done after a time [s]."""
        if elapsed >= self.duration:
            return 1.0
        if elapsed <= 0.0:
            return 0.0
        if self.ramp is None:
            return progress(elapsed / self.duration)
        if elapsed > self.duration / 2:
            return 1.0 - self.progress(self.duration - elapsed)
        u = min(1.0, elapsed / self.ramp)
        at_peak = elapsed - u * self.ramp
        return (self.ramp * u**3 * (1 - u / 2) + at_peak) / (self.duration - self.ramp)


@dataclass(frozen=True)
class Line:
    """A straight motion from one tool pose to another, at rest at both ends.

    Attributes:
        start, end: tool poses; yaw changes with the same progress as position.
        speed: peak speed of the tool centre [m/s].
        motion: how fast tools speed up, and hands with a wire turn.
        turn_rate: peak rate of an empty hand's turn [rad/s]; None: of a hand with a wire, which
            also speeds up more slowly.
        least_s: the motion takes at least so long [s].
    """

    start: ToolPose
    end: ToolPose
    speed: float
    motion: MotionParameters
    turn_rate: float | None = None
    least_s: float = 0.0

    @property
    def distance(self) -> float:
        """Length of the path [m]."""
        a, b = self.start, self.end
        return math.hypot(b.x - a.x, b.y - a.y, b.z - a.z)

    @property
    def turn(self) -> float:
        """The hand's turn [rad]."""
        return abs(self.end.yaw - self.start.yaw)

    @property
    def at_peak_s(self) -> float:
        """How long it would take at its peak speed all the way [s]."""
        rate = self.motion.wire_turn_rate_rad_s if self.turn_rate is None else self.turn_rate
        return max(self.distance / self.speed, self.turn / rate)

    @property
    def ramp_s(self) -> float:
        """How long it takes to that speed [s]."""
        motion, at_peak_s = self.motion, self.at_peak_s
        if at_peak_s == 0.0:
            return 0.0
        most, most_turn = (
            (motion.wire_ramp_m_s2, motion.wire_ramp_turn_rad_s2)
            if self.turn_rate is None
            else (motion.ramp_m_s2, motion.ramp_turn_rad_s2)
        )
        return RAMP_PEAK * max(self.distance / most, self.turn / most_turn) / at_peak_s

    @cached_property
    def timing(self) -> Timing:
        """How far it is at each time."""
        return timing_of([self])

    @property
    def duration(self) -> float:
        """Time the motion takes [s]."""
        return self.timing.duration

    def at(self, elapsed: float) -> ToolPose:
        """Return the tool pose after `elapsed` seconds."""
        return self.between(self.timing.progress(elapsed))

    def between(self, share: float) -> ToolPose:
        """Return the tool pose at a share of the path."""
        a, b = self.start, self.end
        return ToolPose(
            a.x + share * (b.x - a.x),
            a.y + share * (b.y - a.y),
            a.z + share * (b.z - a.z),
            a.yaw + share * (b.yaw - a.yaw),
        )

    def postures(self, arm: Kinematics) -> Array:
        """Return the arm's postures along the path, (n, joints).

        Raises UNREACHABLE if one does not exist.
        """
        motion = self.motion
        steps = max(self.distance / motion.check_step_m, self.turn / motion.check_step_rad)
        parts = max(1, math.ceil(steps))
        return np.array([arm.joints_for(self.between(i / parts)) for i in range(parts + 1)])

    def paced(self, arm: Kinematics) -> Line:
        """Return the line, slowed so that no joint of an arm on an axis is too fast.

        Raises UNREACHABLE if a posture does not exist.
        """
        if arm.axis is None:
            return self
        times, step_s = np.linspace(0.0, self.duration, self.motion.rate_samples, retstep=True)
        joints = np.array([arm.joints_for(self.at(float(time))) for time in times])
        moved = np.abs(np.diff(joints, axis=0)).max(axis=0)
        slower = float((moved / arm.speeds).max()) / step_s if step_s > 0.0 else 1.0
        return self if slower <= 1.0 else replace(self, least_s=slower * self.duration)


def timing_of(lines: Sequence[Line]) -> Timing:
    """Return the timing of lines that begin and end at the same time: none exceeds its limits."""
    at_peak_s = max(line.at_peak_s for line in lines)
    ramp_s = max(line.ramp_s for line in lines)
    if ramp_s < (PEAK_OVER_MEAN - 1.0) * at_peak_s:
        fastest = Timing(at_peak_s + ramp_s, ramp_s)
    else:
        steepest = max(
            math.sqrt(PEAK_ACCELERATION * line.distance / line.motion.acceleration_m_s2)
            for line in lines
        )
        fastest = Timing(max(PEAK_OVER_MEAN * at_peak_s, steepest))
    slower = max(line.least_s for line in lines)
    if slower <= fastest.duration:
        return fastest
    ramp = None if fastest.ramp is None else fastest.ramp * slower / fastest.duration
    return Timing(slower, ramp)


def progress(time: float) -> float:
    """Return the share of a minimum-jerk motion that is done after a share of its time."""
    return time**3 * (10 - 15 * time + 6 * time * time)
