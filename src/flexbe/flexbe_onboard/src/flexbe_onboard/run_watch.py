"""What is seen of the engine beside its status: hangs of states, userdata, and that it is alive.

Python cannot end a thread that hangs. The node can only report it, or end as a whole: roslaunch
then respawns it, and its clients notice that.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from enum import Enum

import rospy
from flexbe_msgs.msg import UserdataInfo
from flexbe_msgs.srv import GetUserdata, GetUserdataRequest, GetUserdataResponse
from std_msgs.msg import Empty

from flexbe_core import Behavior, Logger

# [s] An execution that still hangs is reported again after this long.
REPORT_AGAIN_S = 60.0


class HangPolicy(Enum):
    """What happens when a state does not return."""

    REPORT = "report"
    """Report it to the operator; the behavior continues if the state returns after all."""
    RESTART = "restart"
    """Cancel the goals of the behavior, end it as failed, and restart the engine."""


class HangAlarm:
    """Reports each hang once, and again each REPORT_AGAIN_S."""

    def __init__(self, limit_s: float) -> None:
        """Treat executions longer than `limit_s` [s] as hangs; 0 disables the alarm."""
        self._limit_s = limit_s
        self._since = 0.0
        self._report_at = 0.0

    def check(self, since: float | None, now: float) -> float | None:
        """Return how long [s] an execution has taken, if that is to be reported now.

        Args:
            since: [s] when it began, by any clock that only goes forward; None between executions.
            now: [s] by the same clock.
        """
        if since is None or not self._limit_s:
            return None
        if since != self._since:
            self._since, self._report_at = since, since + self._limit_s
        if now < self._report_at:
            return None
        self._report_at = now + REPORT_AGAIN_S
        return now - since


class HangWatch:
    """Checks the running behavior on each call, from another thread."""

    def __init__(
        self,
        limit_s: float,
        running: Callable[[], Behavior | None],
        on_hang: Callable[[Behavior, str], None],
    ) -> None:
        """Prepare to watch.

        Args:
            limit_s: [s] wall time of an execution that counts as a hang; 0 for none.
            running: returns the behavior that runs.
            on_hang: called with the behavior and the path of the state, after the report.
        """
        self._alarm = HangAlarm(limit_s)
        self._running = running
        self._on_hang = on_hang

    def check(self) -> None:
        """Check once, and report a hang."""
        behavior = self._running()
        found = behavior.get_execution() if behavior is not None else None
        path, since = found or ("", None)
        hanging_s = self._alarm.check(since, time.monotonic())
        if behavior is not None and hanging_s is not None:
            Logger.logerr(
                "%s has not returned for %.1f s: until it does, the engine executes nothing else "
                "and applies no command, not even a preempt",
                *(path or "the behavior's only state", hanging_s),
            )
            self._on_hang(behavior, path)


# Serve the userdata of the running behavior


class UserdataService:
    """Serves flexbe/get_userdata."""

    def __init__(self, running: Callable[[], Behavior | None]) -> None:
        """Serve what `running` returns."""
        self._running = running
        rospy.Service("flexbe/get_userdata", GetUserdata, self._answer)

    def _answer(self, request: GetUserdataRequest) -> GetUserdataResponse:
        behavior = self._running()
        if behavior is None:
            return GetUserdataResponse(success=False, message="no behavior is running")
        wanted = request.userdata_key
        found = [info for info in _userdata(behavior) if wanted in ("", info.key)]
        if not found:
            text = f"{behavior.name} has no userdata" + (f" with key {wanted!r}" if wanted else "")
            return GetUserdataResponse(success=False, message=text)
        return GetUserdataResponse(True, f"{len(found)} values of {behavior.name}", found)


def _userdata(behavior: Behavior) -> Iterator[UserdataInfo]:
    for path, data in behavior.get_userdata().items():
        state = f"{behavior.name}{path}/" if path else behavior.name
        for key, value in data.items():
            yield UserdataInfo(state, key, type(value).__name__, str(value))


# Publish that the engine is alive


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
