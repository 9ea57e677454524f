"""Decide when an execution that does not return is a hang, and when to report it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

# [s] An execution that still hangs is reported again after this long.
REPORT_AGAIN_S = 60.0


class HangPolicy(Enum):
    """What happens when a state does not return."""

    REPORT = "report"
    """Report it to the operator; the behavior continues if the state returns after all."""
    RESTART = "restart"
    """Cancel the goals of the behavior, end it as failed, and restart the engine."""


@dataclass(frozen=True)
class Execution:
    """A state that is being executed.

    Attributes:
        path: its path.
        since: [s] when the execution began, by any clock that only goes forward.
    """

    path: str
    since: float


class HangAlarm:
    """Reports each hang once, and again each REPORT_AGAIN_S."""

    def __init__(self, limit_s: float) -> None:
        """Treat executions longer than `limit_s` [s] as hangs; 0 disables the alarm."""
        self._limit_s = limit_s
        self._since = 0.0
        self._report_at = 0.0

    def check(self, execution: Execution | None, now: float) -> float | None:
        """Return how long [s] the execution has taken, if that is to be reported now."""
        if execution is None or not self._limit_s:
            return None
        if execution.since != self._since:
            self._since, self._report_at = execution.since, execution.since + self._limit_s
        if now < self._report_at:
            return None
        self._report_at = now + REPORT_AGAIN_S
        return now - execution.since
