"""What runs have taught about abilities, in place of what a use case states.

Durations are learned as shares of the stated ones, which know of lengths and conditions.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from remodel_planning.core.condition import Features, Value
from remodel_planning.core.use_case.context import context_of
from remodel_planning.core.use_case.expectation import Expectation, FrozenExpectations
from remodel_states.core.codes import Code
from remodel_supervision.core.learning.belief import Belief
from remodel_supervision.core.learning.duration_model import DurationModel
from remodel_supervision.core.learning.success_model import SuccessModel

# The codes of calls that show nothing about an ability.
UNINFORMATIVE = frozenset({Code.PREEMPTED, Code.INVALID_GOAL, Code.SERVER_LOST, Code.BUSY})


@dataclass(frozen=True)
class Call:
    """A recorded call of an ability.

    Attributes:
        features: of the task that it was part of.
        error_code: Code, 0 for none.
        elapsed_s: [s] ROS time.
        parameters: numbers of its goal, by name.
    """

    ability: str
    features: Mapping[str, Value]
    error_code: int
    elapsed_s: float
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_informative(self) -> bool:
        """Whether anything about the ability can be learned from it."""
        return self.error_code not in UNINFORMATIVE


class LearnedExpectations:
    """Expectations that begin with the stated ones and follow what is recorded."""

    def __init__(self, stated: FrozenExpectations, calls: Iterable[Call] = ()) -> None:
        """Take in recorded calls, in their order."""
        self._stated = stated
        self._success = SuccessModel()
        self._duration = DurationModel()
        self.calls = 0
        for call in calls:
            self.learn(call)

    def learn(self, call: Call) -> None:
        """Take in a call; ignored are uninformative ones, and those of unstated abilities."""
        if call.ability not in self._stated.stated or not call.is_informative:
            return
        self.calls += 1
        context = context_of(call.ability, call.features)
        self._success.learn(context, call.error_code == 0)
        stated_s = self._stated.expect(call.ability, call.features).duration_s
        if stated_s > 0 and call.error_code == 0:
            self._duration.learn(context, call.elapsed_s / stated_s)

    def expect(self, ability: str, features: Features) -> Expectation:
        """Return what is expected of a call of the ability for a task with these features."""
        stated = self._stated.expect(ability, features)
        context = context_of(ability, features)
        share = self._duration.belief(context, 1.0).mean_s
        return Expectation(stated.duration_s * share, self.belief(ability, features).mean)

    def belief(self, ability: str, features: Features) -> Belief:
        """Return what is believed about the success of an ability."""
        stated = self._stated.expect(ability, features)
        return self._success.belief(context_of(ability, features), stated.success)


def numbers_from(parameters: Iterable[tuple[str, str]]) -> dict[str, float]:
    """Return those of an operation's parameters, name and value as text, that are numbers."""
    numbers = {}
    for name, value in parameters:
        try:
            numbers[name] = float(value)
        except ValueError:
            continue
    return numbers
