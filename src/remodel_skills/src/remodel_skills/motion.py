"""Straight tool motions, smooth in time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from remodel_skills.parameters import MotionParameters
from remodel_work.geometry import Array
from remodel_work.robot.arm import Kinematics, ToolPose

# A minimum-jerk motion peaks at 15/8 of its mean speed.
PEAK_OVER_MEAN = 15.0 / 8.0
# Its acceleration peaks at 10 / sqrt(3) of its distance over the square of its time.
PEAK_ACCELERATION = 10.0 / math.sqrt(3.0)


@dataclass(frozen=True)
class Line:
    """A straight motion from one tool pose to another, at rest at both ends.

    Attributes:
        start, end: tool poses; yaw changes with the same progress as position.
        speed: peak speed of the tool centre [m/s].
        motion: how fast tools speed up, and hands with a wire turn.
        turn_rate: peak rate of the hand's turn [rad/s]; None: of a hand with a wire.
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
    def duration(self) -> float:
        """Time the motion takes [s]."""
        motion, turn = self.motion, abs(self.end.yaw - self.start.yaw)
        rate = motion.wire_turn_rate_rad_s if self.turn_rate is None else self.turn_rate
        fastest = PEAK_OVER_MEAN * max(self.distance / self.speed, turn / rate)
        steepest = math.sqrt(PEAK_ACCELERATION * self.distance / motion.acceleration_m_s2)
        return max(fastest, steepest, self.least_s)

    def at(self, elapsed: float) -> ToolPose:
        """Return the tool pose after `elapsed` seconds."""
        duration = self.duration
        t = 1.0 if duration <= 0 else min(1.0, max(0.0, elapsed / duration))
        return self.between(progress(t))

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
        motion, turn = self.motion, abs(self.end.yaw - self.start.yaw)
        steps = max(self.distance / motion.check_step_m, turn / motion.check_step_rad)
        parts = max(1, math.ceil(steps))
        return np.array([arm.joints_for(self.between(i / parts)) for i in range(parts + 1)])

    def paced(self, arm: Kinematics) -> Line:
        """Return the line, slowed so that no joint of an arm on an axis is too fast.

        Raises UNREACHABLE if a posture does not exist.
        """
        if arm.axis is None:
            return self
        samples = self.motion.rate_samples
        shares = [progress(t) for t in np.linspace(0.0, 1.0, samples)]
        joints = np.array([arm.joints_for(self.between(share)) for share in shares])
        rates = np.abs(np.diff(joints, axis=0)).max(axis=0) * (samples - 1)
        return replace(self, least_s=float((rates / arm.speeds).max()))


def progress(time: float) -> float:
    """Return the share of a minimum-jerk motion that is done after a share of its time."""
    return time**3 * (10 - 15 * time + 6 * time * time)
