"""Publish that the engine is alive."""

from __future__ import annotations

import threading
from collections.abc import Callable

import rospy
from std_msgs.msg import Empty

# [s] Wall time; operators expect 1 Hz.
_PERIOD_S = 1.0


class Heartbeat:
    """Publishes flexbe/heartbeat as long as the process lives."""

    def __init__(self, at_each_beat: Callable[[], None]) -> None:
        """Begin at once, and call `at_each_beat` too: an idle engine has one thread that wakes."""
        self._at_each_beat = at_each_beat
        self._publisher = rospy.Publisher("flexbe/heartbeat", Empty, queue_size=100)
        self._ended = threading.Event()
        rospy.on_shutdown(self._ended.set)
        threading.Thread(target=self._beat, name="heartbeat", daemon=True).start()

    def _beat(self) -> None:
        self._publisher.publish()
        while not self._ended.wait(_PERIOD_S):
            self._publisher.publish()
            self._at_each_beat()
