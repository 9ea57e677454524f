"""Which value of a parameter to try next: the best, as far as one can know, within a guard rail.

Thompson sampling (Thompson, Biometrika 25, 1933) over a few values within safe bounds, on beliefs
that forget (Raj and Kalyani, arXiv:1707.09727), held back as a conservative bandit is (Wu et al.,
ICML 2016): another value than the frozen one is tried only as long as all trials of others have
not cost more successes than the guard rail allows, by a cautious account.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from remodel_planner.core.learning.belief import Belief
from remodel_planner.core.learning.success_model import Context, SuccessModel

# [standard deviations] By which the successes of trials may have been luck.
_CAUTION = 3.0

# [1] Probability of success that nothing is known about; in the account, that of the frozen value.
_UNKNOWN = 0.5
_AT_BEST = 0.99


@dataclass(frozen=True)
class GuardRail:
    """How many successes learning may cost, against the frozen value all along.

    Attributes:
        share: of all trials so far.
        slack: besides.
        credit: what good choices may earn at most, to be spent on later trials.
    """

    share: float = 0.02
    slack: float = 5.0
    credit: float = 5.0


_GUARD = GuardRail()


class ParameterChoice:
    """The values of one parameter, by context."""

    def __init__(
        self,
        values: Sequence[float],
        frozen: float,
        guard: GuardRail = GuardRail(),
    ) -> None:
        """Begin with nothing learned.

        Args:
            values: that are safe.
            frozen: the one that is used without learning; one of them.
            guard: see GuardRail.

        Raises:
            ValueError: if the frozen value is not among the safe ones.
        """
        if frozen not in values:
            raise ValueError(f"the frozen value {frozen:g} is not among the safe ones: {values}")
        self.frozen = frozen
        self._values = tuple(values)
        self._guard = guard
        self._models = {value: SuccessModel() for value in values}
        self._trials = 0
        self._cost = 0.0
        self._variance = 0.0

    def choose(self, context: Context, random: Random) -> float:
        """Return the value to try next."""
        if self._cost_at_most() + 1.0 > self._guard.share * self._trials + self._guard.slack:
            return self.frozen
        drawn = [(self._belief(v, context).sample(random), v) for v in self._values]
        return max(drawn)[1]

    def learn(self, context: Context, value: float, success: bool) -> None:
        """Take in one trial; values that are not among the safe ones tell nothing."""
        if value not in self._models:
            return
        self._trials += 1
        if value != self.frozen:
            expected = self._models[self.frozen].belief(context, _AT_BEST).interval()[1]
            self._cost = max(self._cost + expected - float(success), -self._guard.credit)
            chance = self._belief(value, context).mean
            self._variance += chance * (1.0 - chance)
        self._models[value].learn(context, success)

    def beliefs(self, context: Context) -> dict[float, Belief]:
        """Return what is believed about each value."""
        return {value: self._belief(value, context) for value in self._values}

    def _cost_at_most(self) -> float:
        """Return what trials of other values have cost, and might have cost but for luck."""
        return self._cost + _CAUTION * math.sqrt(self._variance)

    def _belief(self, value: float, context: Context) -> Belief:
        return self._models[value].belief(context, _UNKNOWN)
