"""Measure how much ROS time passes for a goal, whatever jumps `/clock` makes.

The clock of a simulation may be set back, or far ahead, when the simulation restarts. Such a jump
is not time that an ability had. So the deltas between two readings are added up, without those that
no simulation can produce in the wall time between them.
"""

from __future__ import annotations

from collections.abc import Callable

# A simulation runs this much faster than the wall clock at most.
_MAX_SPEED = 100.0

# [s] Wall time between two readings that is taken into account. A clock that was stopped for long
# and then jumps must not pass for a fast simulation; states read it at 10 Hz or faster.
_MAX_WALL_S = 0.25

# [s] ROS time of one step of `/clock`, at most: it may arrive right after a reading.
_MAX_STEP_S = 1.0


class RosStopwatch:
    """Adds up the ROS time that passes between its readings."""

    def __init__(self, ros_now: Callable[[], float], wall_now: Callable[[], float]) -> None:
        """Start.

        Args:
            ros_now: returns the ROS time [s].
            wall_now: returns a monotonic wall time [s].
        """
        self._ros_now, self._wall_now = ros_now, wall_now
        self._ros_s, self._wall_s = ros_now(), wall_now()
        self._elapsed_s = 0.0

    def read(self) -> float:
        """Return the ROS time [s] that has passed, without jumps."""
        ros_s, wall_s = self._ros_now(), self._wall_now()
        delta_s = ros_s - self._ros_s
        if delta_s == 0.0:
            return self._elapsed_s  # a clock between two steps; the next one may be a large one
        wall_delta_s = min(wall_s - self._wall_s, _MAX_WALL_S)
        if 0.0 < delta_s <= _MAX_SPEED * wall_delta_s + _MAX_STEP_S:
            self._elapsed_s += delta_s
        self._ros_s, self._wall_s = ros_s, wall_s
        return self._elapsed_s
