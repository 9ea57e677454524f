"""Success of abilities by context.

A context is a row of features, the most general first (context.py). The belief about a context
starts from that about the next more general one, which counts as much as LENT trials: where little
is known, what is generally so is expected, and what was seen in place wins as it grows. The most
general belief starts from the use case's own figure.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from remodel_planning.core.use_case.context import Context
from remodel_supervision.core.learning.belief import Belief

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

    def add(self, success: bool) -> None:
        if success:
            self.successes += 1.0
        else:
            self.failures += 1.0


class SuccessModel:
    """What is believed about the success of abilities."""

    def __init__(self, memory: float = MEMORY) -> None:
        """Begin with nothing learned; `memory` is in trials."""
        self._memory = memory
        self._counts: dict[Context, _Counts] = {}

    def learn(self, context: Context, success: bool) -> None:
        """Take in one trial."""
        self.age(context)
        for part in _parts(context):
            self._counts.setdefault(part, _Counts()).add(success)

    def age(self, context: Context) -> None:
        """Trust in what is known a little less: a trial of something else has gone by."""
        for part in _parts(context):
            if part in self._counts:
                self._counts[part].age(self._memory)

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
