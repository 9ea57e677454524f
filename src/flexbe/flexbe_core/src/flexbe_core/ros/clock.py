"""ROS time, as numbers, and how long to wait for it."""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy
from rosgraph_msgs.msg import Clock


def now() -> float:
    """Return the ROS time [s]; the wall clock in a process that is not a ROS node."""
    return rospy.get_time() if rospy.rostime.is_rostime_initialized() else time.time()


def is_simulated() -> bool:
    """Return whether ROS time comes from /clock."""
    return not rospy.rostime.is_wallclock()


class SimulatedAlarm:
    """Calls back when simulated time has reached a point or jumps back."""

    def __init__(self, ring: Callable[[], None]) -> None:
        """Call `ring`, from the thread that receives /clock."""
        self._ring = ring
        self._at = float("inf")
        self._last = now()
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=1)

    def set(self, at: float) -> None:
        """Ring once when simulated time [s] has reached `at`."""
        self._at = at
        if now() >= at:
            self._ring()

    def close(self) -> None:
        """Stop listening."""
        self._subscriber.unregister()

    def _on_clock(self, message: Clock) -> None:
        current, last = message.clock.to_sec(), self._last
        self._last = current
        if current >= self._at or current < last:
            self._at = float("inf")
            self._ring()
