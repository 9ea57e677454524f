"""Decide when an execution that does not return is a hang, and when to tell."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

# [s] An execution that goes on hanging is told again after this long.
TELL_AGAIN_S = 60.0


class HangPolicy(Enum):
    """What happens when a state does not return."""

    REPORT = "report"
    """Tell the operator; the behavior goes on if the state returns after all."""
    RESTART = "restart"
    """Cancel the goals of the behavior, end it as failed, and start the engine anew."""


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
    """Tells each hang once, and again each TELL_AGAIN_S."""

    def __init__(self, limit_s: float) -> None:
        """Take executions longer than `limit_s` [s] for hangs; 0 for none at all."""
        self._limit_s = limit_s
        self._since = 0.0
        self._tell_at = 0.0

    def look(self, execution: Execution | None, now: float) -> float | None:
        """Return how long [s] the execution has taken, if that is to be told now."""
        if execution is None or not self._limit_s:
            return None
        if execution.since != self._since:
            self._since, self._tell_at = execution.since, execution.since + self._limit_s
        if now < self._tell_at:
            return None
        self._tell_at = now + TELL_AGAIN_S
        return now - execution.since
