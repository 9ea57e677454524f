"""Straight tool motions, smooth in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_sim.core.geometry import Array
from remodel_sim.core.robot.arm import Arm, ToolPose

# A minimum-jerk motion peaks at 15/8 of its mean speed.
PEAK_OVER_MEAN = 15.0 / 8.0
# The hand may turn this fast at most [rad/s]; joint 7 of the Panda allows 2.61, but a wire that is
# turned faster pitches in the grip.
MAX_TURN_RATE = 1.6
# Postures are checked this far apart before a motion starts [m], [rad].
CHECK_STEP_M = 0.02
CHECK_STEP_RAD = 0.2


@dataclass(frozen=True)
class Line:
    """A straight motion from one tool pose to another, at rest at both ends.

    Attributes:
        start, end: tool poses; yaw changes with the same progress as position.
        speed: peak speed of the tool centre [m/s].
    """

    start: ToolPose
    end: ToolPose
    speed: float

    @property
    def distance(self) -> float:
        """Length of the path [m]."""
        a, b = self.start, self.end
        return math.hypot(b.x - a.x, b.y - a.y, b.z - a.z)

    @property
    def duration(self) -> float:
        """Time the motion takes [s]."""
        turn = abs(self.end.yaw - self.start.yaw)
        return PEAK_OVER_MEAN * max(self.distance / self.speed, turn / MAX_TURN_RATE)

    def at(self, elapsed: float) -> ToolPose:
        """Return the tool pose after `elapsed` seconds."""
        duration = self.duration
        t = 1.0 if duration <= 0 else min(1.0, max(0.0, elapsed / duration))
        return self._between(t**3 * (10 - 15 * t + 6 * t * t))

    def _between(self, share: float) -> ToolPose:
        a, b = self.start, self.end
        return ToolPose(
            a.x + share * (b.x - a.x),
            a.y + share * (b.y - a.y),
            a.z + share * (b.z - a.z),
            a.yaw + share * (b.yaw - a.yaw),
        )

    def postures(self, arm: Arm) -> Array:
        """Return the arm's postures along the path, (n, 7) [rad].

        Raises UNREACHABLE if one does not exist.
        """
        turn = abs(self.end.yaw - self.start.yaw)
        parts = max(1, math.ceil(max(self.distance / CHECK_STEP_M, turn / CHECK_STEP_RAD)))
        return np.array([arm.joints_for(self._between(i / parts)) for i in range(parts + 1)])
