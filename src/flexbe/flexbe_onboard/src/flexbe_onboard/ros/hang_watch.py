"""Watch whether the states of the running behavior return.

Python cannot end a thread that hangs. So there is nothing to be done but to tell, or to end the
whole node: roslaunch starts it anew, and its clients learn that.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from flexbe_core import Behavior, Logger
from flexbe_onboard.core.hang import Execution, HangAlarm


class HangWatch:
    """Looks at the running behavior whenever it is asked to, from another thread."""

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
            on_hang: told the behavior and the path of the state, once the operator has been.
        """
        self._alarm = HangAlarm(limit_s)
        self._running = running
        self._on_hang = on_hang

    def look(self) -> None:
        """Look once."""
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
