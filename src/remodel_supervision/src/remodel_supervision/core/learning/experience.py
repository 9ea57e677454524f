"""What recorded runs have taught, for one use case; it follows what happens on line.

Durations and successes are learned always: they decide the order of tasks and which method is
cheaper. Parameters, such as forces, are chosen only on request, and responses are skipped only on
request: otherwise the robot does with each wire exactly what its use case and the table of
faults state.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from remodel_planning.core.condition import Features
from remodel_planning.core.use_case.bounds import Bounds
from remodel_planning.core.use_case.fault import Do
from remodel_planning.core.use_case.model import UseCase
from remodel_supervision.core.learning.learned_expectations import Call, LearnedExpectations
from remodel_supervision.core.learning.learned_parameters import LearnedParameters
from remodel_supervision.core.learning.learned_responses import LearnedResponses, TriedResponse


class Experience:
    """Expectations, parameters and responses, as they are learned.

    Attributes:
        expectations: of abilities.
    """

    def __init__(
        self, use_case: UseCase, calls: Iterable[Call] = (), *, explore: bool = False
    ) -> None:
        """Take in recorded calls, in their order.

        Args:
            use_case: what it states counts until calls have taught better.
            calls: recorded.
            explore: choose parameters by what was learned, trying others than the frozen ones, and
                skip responses to faults that have hardly ever helped.
        """
        self.expectations = LearnedExpectations(use_case.expectations)
        self._bounds = use_case.learned
        self._parameters = LearnedParameters()
        self._explores = explore
        for call in calls:
            self.learn(call)

    def learn(self, call: Call) -> None:
        """Take in a call of an ability."""
        self.expectations.learn(call)
        if self._explores:
            self._parameters.learn(call)

    def parameters(
        self, ability: str, features: Features, limits: Mapping[str, float], seed: str
    ) -> dict[str, float]:
        """Return the parameters with which an ability is to be called, beside what its chart says.

        Args:
            ability: such as "InsertCable".
            features: of the call, see context.py.
            limits: parameter -> what it must not exceed here.
            seed: of what is left to chance, such as run, task and attempt.

        Returns:
            Parameter -> value; empty where the use case's own are to be kept, always so unless
            this explores.
        """
        bounds = _within(self._bounds.get(ability, {}), limits)
        if not self._explores or not bounds:
            return {}
        chosen = self._parameters.choose(ability, features, bounds, seed)
        return {name: value for name, value in chosen.items() if value != bounds[name].frozen}

    def unpromising(
        self, fault: str, possible: Collection[Do], responses: Iterable[TriedResponse]
    ) -> frozenset[Do]:
        """Return the responses that have hardly ever helped against a fault.

        Without exploring there are none: the policy is followed as it stands.

        Args:
            fault: its name.
            possible: the responses that can be given.
            responses: recorded.
        """
        if not self._explores:
            return frozenset()
        return frozenset(possible) - LearnedResponses(responses).promising(fault, possible)


def _within(bounds: Mapping[str, Bounds], limits: Mapping[str, float]) -> dict[str, Bounds]:
    """Return bounds narrowed to what is allowed; none at all if the frozen values are not."""
    narrowed = {
        name: replace(each, high=min(each.high, limits.get(name, each.high)))
        for name, each in bounds.items()
        if limits.get(name, each.frozen) >= each.frozen
    }
    return narrowed if len(narrowed) == len(bounds) else {}
