"""Watch whether the states of the running behavior return.

Python cannot end a thread that hangs. So there is nothing to be done but to tell, or to end the
whole node: roslaunch starts it anew, and its clients learn that.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import rospy

from flexbe_core import Behavior, Logger
from flexbe_onboard.core.hang import Execution, HangAlarm

# [s] Wall time between two looks.
_LOOK_EVERY_S = 0.25


class HangWatch:
    """Looks at the running behavior from a thread of its own."""

    def __init__(
        self,
        limit_s: float,
        running: Callable[[], Behavior | None],
        on_hang: Callable[[Behavior, str], None],
    ) -> None:
        """Begin to watch.

        Args:
            limit_s: [s] wall time of an execution that counts as a hang; 0 for none.
            running: returns the behavior that runs.
            on_hang: told the behavior and the path of the state, once the operator has been.
        """
        self._alarm = HangAlarm(limit_s)
        self._running = running
        self._on_hang = on_hang
        self._ended = threading.Event()
        rospy.on_shutdown(self._ended.set)
        threading.Thread(target=self._watch, name="hang_watch", daemon=True).start()

    def _watch(self) -> None:
        while not self._ended.wait(_LOOK_EVERY_S):
            behavior = self._running()
            found = behavior.get_execution() if behavior is not None else None
            execution = Execution(*found) if found is not None else None
            hanging_s = self._alarm.look(execution, time.monotonic())
            if behavior is not None and execution is not None and hanging_s is not None:
                Logger.logerr(
                    "%s has not returned for %.1f s: until it does, nothing else is executed and "
                    "no command obeyed, not even a preempt",
                    *(execution.path or "the behavior's only state", hanging_s),
                )
                self._on_hang(behavior, execution.path)
