"""Success of abilities by context.

A context is a row of features, the most general first: (ability, terminal type, gauge, view). The
belief about a context starts from that about the next more general one, which counts as much as
LENT trials: where little is known, what is generally so is expected, and what was seen in place
wins as it grows. The most general belief starts from the use case's own figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from remodel_planner.core.learning.belief import Belief

Context = tuple[str, ...]

# [trials] Weight of the more general belief.
LENT = 8.0

# [trials] Over which a model remembers: the weight of each trial falls by 1/MEMORY with each later
# one of the same context, so that it follows an ability that changes.
MEMORY = 200.0


@dataclass
class _Counts:
    successes: float = 0.0
    failures: float = 0.0

    def add(self, success: bool) -> None:
        self.successes *= 1.0 - 1.0 / MEMORY
        self.failures *= 1.0 - 1.0 / MEMORY
        if success:
            self.successes += 1.0
        else:
            self.failures += 1.0


class SuccessModel:
    """What is believed about the success of abilities."""

    def __init__(self) -> None:
        """Begin with nothing learned."""
        self._counts: dict[Context, _Counts] = {}

    def learn(self, context: Context, success: bool) -> None:
        """Take in one trial."""
        for length in range(1, len(context) + 1):
            self._counts.setdefault(context[:length], _Counts()).add(success)

    def belief(self, context: Context, stated: float) -> Belief:
        """Return what is believed about a context.

        Args:
            context: what to look at.
            stated: probability that the use case states, 0 to 1.
        """
        belief = _lent(min(max(stated, 0.01), 0.99))
        for length in range(1, len(context) + 1):
            counts = self._counts.get(context[:length])
            if counts is None:
                break
            lent = _lent(belief.mean) if length > 1 else belief
            belief = Belief(lent.successes + counts.successes, lent.failures + counts.failures)
        return belief


def fold(trials: Sequence[tuple[Context, bool]]) -> SuccessModel:
    """Return the model that has taken in these trials."""
    model = SuccessModel()
    for context, success in trials:
        model.learn(context, success)
    return model


def _lent(mean: float) -> Belief:
    return Belief(LENT * mean, LENT * (1.0 - mean))
