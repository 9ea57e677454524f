"""What is believed of an ability from trials: how often it succeeds, and how long it takes.

And which setting of its parameters to try next: the best one, within a guard rail. Thompson
sampling (Thompson, Biometrika 25, 1933) over a few safe settings, on beliefs that forget with every
trial, whichever setting it tried (discounted Thompson sampling: Raj and Kalyani, arXiv:1707.09727),
held back as a conservative bandit is (Wu et al., ICML 2016).

The guard rail is an account of what trials of other settings than the frozen one have cost. Each is
charged the success that the frozen setting would have had, at the upper end of what is believed
about it, less the success that came. With every trial the debt falls by the share that learning may
cost, never below zero: earlier gains are no credit. While the debt, with some allowance for luck,
is too high, the frozen setting is used, which also shows how good it is now.

What is believed about the frozen setting ages fast: untried for a while, it counts as nearly
perfect again, and the account sends trials to it. When trials fail more often than was believed of
their settings, something has changed, and it counts as nearly perfect at once.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from types import MappingProxyType
from typing import Generic, TypeVar

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


S = TypeVar("S", bound=Hashable)

# The constants below were chosen by simulating the drifts of test_learning.py.

# [1] The debt at which the account stops, of the guard's slack: the rest covers what a change costs
# until it shows.
_DEBT_SHARE = 0.3

# [trials] Over which a setting is remembered: several must be distinguished.
_MEMORY = 400.0

# [1], [trials] What is assumed of a setting of which nothing is known, and the weight of that.
_UNKNOWN, _UNKNOWN_WEIGHT = 0.5, 2.0

# [trials] Weight of what is believed of a neighbour.
_NEAR_WEIGHT = 1.0

# [1], [trials] The same of the frozen setting in the account, and how long it remembers trials.
_AT_BEST, _AT_BEST_WEIGHT, _BASELINE_MEMORY = 0.99, 2.0, 40.0

# [standard deviations] of that belief at which the frozen setting is charged.
_DOUBT = 1.0

# [failures] More of them than was believed, and how many of them in a trial are no surprise
# (Page's cumulative sum, Biometrika 41, 1954).
_SURPRISE, _NO_SURPRISE = 2.0, 0.1


@dataclass(frozen=True)
class GuardRail:
    """How many successes learning may cost, against the frozen setting all along.

    It holds for every stretch of trials, wherever it begins.

    Attributes:
        share: of the trials of the stretch.
        slack: besides.
    """

    share: float = 0.02
    slack: float = 20.0


DEFAULT_GUARD = GuardRail()


class ParameterChoice(Generic[S]):
    """The settings of one ability's parameters, by context."""

    def __init__(
        self,
        settings: Sequence[S],
        frozen: S,
        guard: GuardRail = DEFAULT_GUARD,
        nearer: Mapping[S, S] = MappingProxyType({}),
    ) -> None:
        """Begin with nothing learned.

        Args:
            settings: that are safe.
            frozen: the one that is used without learning; one of them.
            guard: see GuardRail.
            nearer: setting -> its neighbour on the way to the frozen one, from which it is expected
                to differ little; of those that are left out nothing is expected.

        Raises:
            ValueError: if the frozen setting is not among the safe ones.
        """
        if frozen not in settings:
            raise ValueError(f"the frozen {frozen} is not among the safe ones: {settings}")
        self.frozen = frozen
        self._guard = guard
        self._nearer = nearer
        self._models = {setting: SuccessModel(_MEMORY) for setting in settings}
        self._baseline = SuccessModel(_BASELINE_MEMORY)
        self._debt = 0.0
        self._variance = 0.0
        self._surprise = 0.0

    def choose(self, context: Context, random: Random) -> S:
        """Return the setting to try next."""
        next_one = 1.0 + math.sqrt(self._variance)
        if self._debt + next_one > _DEBT_SHARE * self._guard.slack:
            return self.frozen
        drawn = {setting: self._belief(setting, context).sample(random) for setting in self._models}
        return max(drawn, key=drawn.__getitem__)

    def learn(self, context: Context, setting: S, success: bool) -> None:
        """Take in one trial; settings that are not among the safe ones are ignored."""
        if setting not in self._models:
            return
        if setting == self.frozen:
            self._baseline.learn(context, success)
        else:
            self._charge(context, setting, success)
            self._baseline.age(context)
        self._debt -= self._guard.share
        if self._debt <= 0.0:
            self._debt = self._variance = 0.0
        for other, model in self._models.items():
            if other == setting:
                model.learn(context, success)
            else:
                model.age(context)

    def learn_rehearsed(self, context: Context, setting: S, success: bool, weight: float) -> None:
        """Take in a trial of the simulated cell, which counts as so many [trials].

        It costs the robot nothing, so the guard's account takes no notice of it, and what the
        account knows of the frozen setting is of the robot alone.
        """
        if setting in self._models:
            self._models[setting].learn(context, success, weight)

    def beliefs(self, context: Context) -> dict[S, Belief]:
        """Return what is believed about each setting."""
        return {setting: self._belief(setting, context) for setting in self._models}

    def _charge(self, context: Context, setting: S, success: bool) -> None:
        """Enter a trial of another setting than the frozen one into the account."""
        chance = self._belief(setting, context).mean
        frozen = self._baseline.belief(context, _AT_BEST, _AT_BEST_WEIGHT).interval(_DOUBT)[1]
        self._debt += frozen - float(success)
        self._variance += chance * (1.0 - chance)
        self._surprise = max(0.0, self._surprise + chance - float(success) - _NO_SURPRISE)
        if self._surprise > _SURPRISE:
            self._surprise = 0.0
            self._baseline = SuccessModel(_BASELINE_MEMORY)

    def _belief(self, setting: S, context: Context) -> Belief:
        expected, weight = _UNKNOWN, _UNKNOWN_WEIGHT
        if setting in self._nearer:
            expected, weight = self._belief(self._nearer[setting], context).mean, _NEAR_WEIGHT
        return self._models[setting].belief(context, expected, weight)
