"""The beat at which a single state is executed by hand: execute, sleep, execute, sleep."""

from __future__ import annotations

import rospy

from flexbe_core.engine.definitions.rate import period_s
from flexbe_core.ros import clock


class Beat:
    """Sleeps to the next beat, whatever happened in between, as rospy.Rate does.

    Attributes:
        rate: the state's `_rate`; of another one, there is another beat.
    """

    def __init__(self, rate: object) -> None:
        """Begin to beat now."""
        self.rate = rate
        self._last = clock.now()

    def remaining_s(self) -> float:
        """Return how long [s] until the next beat; negative if it is late."""
        now = clock.now()
        self._last = min(self._last, now)
        return self._last + period_s(self.rate) - now

    def sleep(self) -> None:
        """Sleep until the next beat; one that is late by more than a period is left out."""
        rospy.sleep(max(0.0, self.remaining_s()))
        now = clock.now()
        self._last += period_s(self.rate)
        if now - self._last > period_s(self.rate):
            self._last = now
