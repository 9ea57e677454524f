"""ROS time without the jumps of /clock."""

from __future__ import annotations

# [s] by which ROS time may pass between two readings, whatever the wall clock says, and how many
# times faster than the wall clock it may pass.
_ALWAYS_S = 5.0
_FASTEST = 100.0


class SteadyClock:
    """Adds up the plausible steps of a clock that may jump back, or far forward."""

    def __init__(self) -> None:
        """Begin at the first reading."""
        self._ros_s: float | None = None
        self._wall_s = 0.0
        self._now_s = 0.0

    def read(self, ros_s: float, wall_s: float) -> float:
        """Return the steady time [s].

        Args:
            ros_s: [s] ROS time.
            wall_s: [s] monotonic wall time.
        """
        if self._ros_s is None:
            self._now_s = ros_s
        else:
            step_s = ros_s - self._ros_s
            if 0.0 <= step_s <= _ALWAYS_S + _FASTEST * (wall_s - self._wall_s):
                self._now_s += step_s
        self._ros_s, self._wall_s = ros_s, wall_s
        return self._now_s
