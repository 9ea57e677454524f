"""Watch whether the states of the running behavior return.

Python cannot end a thread that hangs. The node can only report it, or end as a whole: roslaunch
then respawns it, and its clients notice that.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from flexbe_core import Behavior, Logger
from flexbe_onboard.core.hang import Execution, HangAlarm


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
        execution = Execution(*found) if found is not None else None
        hanging_s = self._alarm.check(execution, time.monotonic())
        if behavior is not None and execution is not None and hanging_s is not None:
            Logger.logerr(
                "%s has not returned for %.1f s: until it does, the engine executes nothing else "
                "and applies no command, not even a preempt",
                *(execution.path or "the behavior's only state", hanging_s),
            )
            self._on_hang(behavior, execution.path)
