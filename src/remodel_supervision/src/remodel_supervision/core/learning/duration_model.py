"""Duration of abilities by context, in the manner of success_model.py.

Durations are positive and now and then much longer than usual: their logarithms are averaged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from remodel_planning.core.use_case.context import Context
from remodel_supervision.core.learning.success_model import LENT, MEMORY

# [1] Spread of the logarithm of a duration of which nothing is known: a factor of about 1.5.
_STATED_DEVIATION = 0.4


@dataclass(frozen=True)
class Duration:
    """What is believed about a duration.

    Attributes:
        median_s: [s] half of the times it takes less.
        log_deviation: standard deviation of its natural logarithm.
    """

    median_s: float
    log_deviation: float

    @property
    def mean_s(self) -> float:
        """[s] The expected duration, of a log-normal distribution."""
        return self.median_s * math.exp(self.log_deviation**2 / 2)


@dataclass
class _Sums:
    weight: float = 0.0
    logs: float = 0.0
    squares: float = 0.0

    def add(self, log_s: float) -> None:
        keep = 1.0 - 1.0 / MEMORY
        self.weight = keep * self.weight + 1.0
        self.logs = keep * self.logs + log_s
        self.squares = keep * self.squares + log_s**2


class DurationModel:
    """What is believed about the duration of abilities."""

    def __init__(self) -> None:
        """Begin with nothing learned."""
        self._sums: dict[Context, _Sums] = {}

    def learn(self, context: Context, duration_s: float) -> None:
        """Take in one duration [s]; those that are not positive are ignored."""
        if duration_s > 0:
            for length in range(1, len(context) + 1):
                self._sums.setdefault(context[:length], _Sums()).add(math.log(duration_s))

    def belief(self, context: Context, stated_s: float) -> Duration:
        """Return what is believed about a context.

        Args:
            context: of the ability.
            stated_s: [s] mean that the use case states, > 0.
        """
        mean = math.log(stated_s) - _STATED_DEVIATION**2 / 2
        variance = _STATED_DEVIATION**2
        for length in range(1, len(context) + 1):
            sums = self._sums.get(context[:length])
            if sums is None:
                break
            total = LENT + sums.weight
            new = (LENT * mean + sums.logs) / total
            square = LENT * (variance + mean**2) + sums.squares
            mean, variance = new, max(square / total - new**2, 0.0)
        return Duration(math.exp(mean), math.sqrt(variance))
