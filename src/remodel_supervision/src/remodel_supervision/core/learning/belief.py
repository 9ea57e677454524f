"""What is believed of an ability from trials: how often it succeeds, and how long it takes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from remodel_tasks.core.condition import Context


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


# [trials] Weight of the more general belief.
LENT = 8.0

# [trials] Over which a model remembers: the weight of each trial falls by 1/MEMORY with each later
# one of the same context, so that it follows an ability that changes.
MEMORY = 200.0


@dataclass
class _Counts:
    successes: float = 0.0
    failures: float = 0.0

    def age(self, memory: float) -> None:
        self.successes *= 1.0 - 1.0 / memory
        self.failures *= 1.0 - 1.0 / memory

    def add(self, success: bool, weight: float) -> None:
        if success:
            self.successes += weight
        else:
            self.failures += weight


class SuccessModel:
    """What is believed about the success of abilities."""

    def __init__(self, memory: float = MEMORY) -> None:
        """Begin with nothing learned; `memory` is in trials."""
        self._memory = memory
        self._counts: dict[Context, _Counts] = {}

    def learn(self, context: Context, success: bool, weight: float = 1.0) -> None:
        """Take in one trial, which counts as so many [trials], at most 1."""
        self.age(context, weight)
        for part in _parts(context):
            self._counts.setdefault(part, _Counts()).add(success, weight)

    def age(self, context: Context, weight: float = 1.0) -> None:
        """Trust in what is known a little less: a trial of something else has gone by."""
        for part in _parts(context):
            if part in self._counts:
                self._counts[part].age(self._memory / weight)

    def belief(self, context: Context, stated: float, weight: float = LENT) -> Belief:
        """Return what is believed about a context.

        Args:
            context: of the ability.
            stated: probability that the use case states, 0 to 1.
            weight: [trials] of what is stated.
        """
        belief = _lent(min(max(stated, 0.01), 0.99), weight)
        for part in _parts(context):
            counts = self._counts.get(part)
            if counts is None:
                break
            lent = _lent(belief.mean) if len(part) > 1 else belief
            belief = Belief(lent.successes + counts.successes, lent.failures + counts.failures)
        return belief


def _parts(context: Context) -> Iterator[Context]:
    """Yield a context and those that it is a case of, the most general first."""
    for length in range(1, len(context) + 1):
        yield context[:length]


def _lent(mean: float, weight: float = LENT) -> Belief:
    return Belief(weight * mean, weight * (1.0 - mean))


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

    def add(self, log_s: float, weight: float) -> None:
        keep = 1.0 - weight / MEMORY
        self.weight = keep * self.weight + weight
        self.logs = keep * self.logs + weight * log_s
        self.squares = keep * self.squares + weight * log_s**2


class DurationModel:
    """What is believed about the duration of abilities."""

    def __init__(self) -> None:
        """Begin with nothing learned."""
        self._sums: dict[Context, _Sums] = {}

    def learn(self, context: Context, duration_s: float, weight: float = 1.0) -> None:
        """Take in one duration [s], as SuccessModel does; those not above 0 are ignored."""
        if duration_s > 0:
            for length in range(1, len(context) + 1):
                self._sums.setdefault(context[:length], _Sums()).add(math.log(duration_s), weight)

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
