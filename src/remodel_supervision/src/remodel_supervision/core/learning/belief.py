"""What is believed about a probability."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random


@dataclass(frozen=True)
class Belief:
    """A Beta distribution over a probability of success.

    Attributes:
        successes: pseudo-count of successes, > 0.
        failures: pseudo-count of failures, > 0.
    """

    successes: float
    failures: float

    @property
    def mean(self) -> float:
        """The expected probability."""
        return self.successes / (self.successes + self.failures)

    @property
    def deviation(self) -> float:
        """The standard deviation of the probability."""
        total = self.successes + self.failures
        return math.sqrt(self.mean * (1.0 - self.mean) / (total + 1.0))

    def interval(self, deviations: float = 1.64) -> tuple[float, float]:
        """Return where the probability lies: 90 % of the belief at 1.64 deviations.

        Wilson's score interval (J. Am. Stat. Assoc. 22, 1927), which stays inside 0 to 1 and is
        honest for few trials, on the pseudo-counts.
        """
        total, square = self.successes + self.failures, deviations**2
        middle = (self.mean + square / (2 * total)) / (1 + square / total)
        spread = self.mean * (1 - self.mean) / total + square / (4 * total**2)
        half = deviations * math.sqrt(spread) / (1 + square / total)
        return max(0.0, middle - half), min(1.0, middle + half)

    def sample(self, random: Random) -> float:
        """Return a probability drawn from the belief."""
        return random.betavariate(self.successes, self.failures)
