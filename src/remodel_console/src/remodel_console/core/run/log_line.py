"""Lines of the engine's log, as an operator reads them."""

from __future__ import annotations

from dataclasses import dataclass

_SEVERITIES = {0: "info", 1: "warning", 2: "hint", 3: "error", 10: "debug"}


@dataclass(frozen=True)
class LogLine:
    """One line: when [s, wall time], its code in flexbe_msgs/BehaviorLog, and the text."""

    time_s: float
    code: int
    text: str

    @property
    def severity(self) -> str:
        """Return the word for its code."""
        return _SEVERITIES.get(self.code, "info")
