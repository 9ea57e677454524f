"""Which progress of an action is worth a line."""

from __future__ import annotations

import re

# [%] An action that reports nothing else is printed again after this much more.
_STEP = 25.0

_NUMBER = re.compile(r"\d+(?:\.\d+)?")


class Progress:
    """The progress of one action: a line for each step, and for each quarter of its work."""

    def __init__(self, name: str) -> None:
        """Begin with nothing printed.

        Args:
            name: of the action, such as InsertCable.
        """
        self._name = name
        self._goal = self._step = ""
        self._printed = 0.0

    def line(self, goal: str, step: str, percentage: float) -> str:
        """Return what is worth printing of a feedback; empty if nothing is.

        Args:
            goal: its actionlib id.
            step: what is being done, for a person. Another number in it is no other step.
            percentage: how much is done, 0 to 100.
        """
        what = _NUMBER.sub("", step)
        if goal == self._goal and what == self._step and percentage < self._printed + _STEP:
            return ""
        self._goal, self._step, self._printed = goal, what, percentage
        return f"{self._name} {percentage:.0f} %: {step}"
