"""ROS time, as numbers, and how long to wait for it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import rospy
from rosgraph_msgs.msg import Clock

from flexbe_core.engine.definitions import period_s

# [s] Wall time after which a clock that does not advance has stopped.
STOPPED_S = 5.0

# [s] Wall time between two readings of the clocks.
_WATCH_EVERY_S = 1.0


def now() -> float:
    """Return the ROS time [s]; the wall clock in a process that is not a ROS node."""
    return rospy.get_time() if rospy.rostime.is_rostime_initialized() else time.time()


def is_simulated() -> bool:
    """Return whether ROS time comes from /clock."""
    return not rospy.rostime.is_wallclock()


class Standstill:
    """Whether simulated time has stopped, by readings of both clocks."""

    def __init__(self) -> None:
        self._at = -1.0
        self._since = 0.0
        self._is_reported = False

    def reading(self, ros_s: float, wall_s: float) -> str:
        """Return a sentence once when time has stopped for STOPPED_S; empty otherwise.

        Args:
            ros_s: [s] ROS time.
            wall_s: [s] wall time of a monotonic clock.
        """
        if ros_s != self._at:
            self._at, self._since, self._is_reported = ros_s, wall_s, False
        if self._is_reported or wall_s - self._since < STOPPED_S:
            return ""
        self._is_reported = True
        what = (
            f"/clock has stopped at {ros_s:.1f} s"
            if ros_s
            else "/use_sim_time is true, and no node publishes /clock"
        )
        return (
            f"{what}: this node waits until time goes on. Start or resume the simulation; with a "
            "real robot, set /use_sim_time to false and start all nodes again"
        )


def report_standstill() -> None:
    """Log a warning whenever simulated time stops, from a thread of its own; once each time."""
    if is_simulated():
        threading.Thread(target=_watch_clock, name="clock watch", daemon=True).start()


def _watch_clock() -> None:
    standstill = Standstill()
    while not rospy.core.is_shutdown_requested():
        if text := standstill.reading(rospy.get_time(), time.monotonic()):
            rospy.logwarn("%s", text)
        time.sleep(_WATCH_EVERY_S)


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


# The beat at which a single state is executed by hand: execute, sleep, execute, sleep


class Beat:
    """Sleeps to the next beat, whatever happened in between, as rospy.Rate does.

    Attributes:
        rate: the state's `_rate`; of another one, there is another beat.
    """

    def __init__(self, rate: object) -> None:
        self.rate = rate
        self._last = now()

    def remaining_s(self) -> float:
        """Return how long [s] until the next beat; negative if it is late."""
        at = now()
        self._last = min(self._last, at)
        return self._last + period_s(self.rate) - at

    def sleep(self) -> None:
        """Sleep until the next beat; one that is late by more than a period is left out."""
        rospy.sleep(max(0.0, self.remaining_s()))
        at = now()
        self._last += period_s(self.rate)
        if at - self._last > period_s(self.rate):
            self._last = at
