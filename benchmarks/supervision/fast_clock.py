"""ROS time that is faster than the wall's: no one waits long for a server that hangs."""

from __future__ import annotations

import contextlib
import threading
import time

import rospy
from rosgraph_msgs.msg import Clock

# [s] wall time between two messages.
_EVERY_S = 0.02


class FastClock:
    """Publishes /clock until the process ends."""

    def __init__(self, speed: float) -> None:
        """Start the clock, this many times as fast as the wall's."""
        self._speed = speed
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=1)
        self._begun = time.monotonic()
        threading.Thread(target=self._tick, name="clock", daemon=True).start()

    def _tick(self) -> None:
        while not rospy.is_shutdown():
            now_s = 1.0 + self._speed * (time.monotonic() - self._begun)
            with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
                self._publisher.publish(Clock(rospy.Time.from_sec(now_s)))
            time.sleep(_EVERY_S)
