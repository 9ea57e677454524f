"""What all runs have taught: expectations, parameters and responses, from recorded calls."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from remodel_states.core.codes import Code
from remodel_supervision.core.learning.belief import (
    DEFAULT_GUARD,
    Belief,
    DurationModel,
    GuardRail,
    ParameterChoice,
    SuccessModel,
)
from remodel_tasks.core.condition import Features, Value, context_of
from remodel_tasks.core.use_case.fault import Do
from remodel_tasks.core.use_case.model import (
    Bounds,
    Expectation,
    FrozenExpectations,
    Setting,
    UseCase,
    frozen_setting,
    nearer_settings,
    settings,
)

# [trials] As how many real ones a rehearsed call counts. The simulated cell succeeds and fails for
# the reasons of a real one, but not as often: five rehearsed calls weigh as much as one real one,
# and the 200 trials that a model remembers are soon those of the robot.
REHEARSED_WEIGHT = 0.2

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
        weight: [trials] as how many it counts; 1 for a real one.
    """

    ability: str
    features: Mapping[str, Value]
    error_code: int
    elapsed_s: float
    parameters: Mapping[str, float] = field(default_factory=dict)
    weight: float = 1.0

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
        self._success.learn(context, call.error_code == 0, call.weight)
        stated_s = self._stated.expect(call.ability, call.features).duration_s
        if stated_s > 0 and call.error_code == 0:
            self._duration.learn(context, call.elapsed_s / stated_s, call.weight)

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


# An ability, and the bounds of its parameters.
_Key = tuple[str, tuple[tuple[str, Bounds], ...]]

# [digits] To which values are compared; records write them as text.
_DIGITS = 9


class LearnedParameters:
    """What is known about the parameters of all abilities."""

    def __init__(self, calls: Iterable[Call] = (), guard: GuardRail = DEFAULT_GUARD) -> None:
        """Take in recorded calls, in their order."""
        self._guard = guard
        self._calls: dict[str, list[Call]] = {}
        self._choices: dict[_Key, ParameterChoice[Setting]] = {}
        for call in calls:
            self.learn(call)

    def learn(self, call: Call) -> None:
        """Take in a call; uninformative ones are ignored."""
        if not call.is_informative:
            return
        self._calls.setdefault(call.ability, []).append(call)
        for (ability, bounds), choice in self._choices.items():
            if ability == call.ability:
                _learn(choice, dict(bounds), call)

    def choose(
        self, ability: str, features: Features, bounds: Mapping[str, Bounds], seed: int | str
    ) -> dict[str, float]:
        """Return the parameters for the next call of an ability.

        Args:
            ability: such as "InsertCable".
            features: of the task, see condition.py.
            bounds: parameter -> its bounds; all parameters are chosen together.
            seed: of what is left to chance, such as run, task and attempt.

        Raises:
            ValueError: if the bounds allow more settings than can be distinguished.
        """
        context = context_of(ability, features)
        random = Random(f"{seed} {context}")
        return dict(self._choice(ability, bounds).choose(context, random))

    def beliefs(
        self, ability: str, features: Features, bounds: Mapping[str, Bounds]
    ) -> dict[Setting, Belief]:
        """Return what is believed about the success of each setting."""
        return self._choice(ability, bounds).beliefs(context_of(ability, features))

    def _choice(self, ability: str, bounds: Mapping[str, Bounds]) -> ParameterChoice[Setting]:
        key = (ability, tuple(sorted(bounds.items())))
        if key not in self._choices:
            choice = ParameterChoice(
                settings(bounds), frozen_setting(bounds), self._guard, nearer_settings(bounds)
            )
            for call in self._calls.get(ability, ()):
                _learn(choice, bounds, call)
            self._choices[key] = choice
        return self._choices[key]


def setting_of(bounds: Mapping[str, Bounds], call: Call) -> Setting | None:
    """Return the setting that a call was made with; None if it was none of those to be tried."""
    setting = []
    for name in sorted(bounds):
        given = call.parameters.get(name, math.nan)
        tried = [v for v in bounds[name].values if round(v - given, _DIGITS) == 0.0]
        if not tried:
            return None
        setting.append((name, tried[0]))
    return tuple(setting)


def _learn(choice: ParameterChoice[Setting], bounds: Mapping[str, Bounds], call: Call) -> None:
    setting = setting_of(bounds, call)
    if setting is not None:
        context, success = context_of(call.ability, call.features), call.error_code == 0
        if call.weight < 1.0:
            choice.learn_rehearsed(context, setting, success, call.weight)
        else:
            choice.learn(context, setting, success)


# [1] A response that surely helps less often costs more time than it saves.
LEAST_HELP = 0.2

# [1], [responses] What is assumed of one that nothing is known about, and the weight of that.
_UNKNOWN, _UNKNOWN_WEIGHT = 0.5, 2.0

# [responses] to the same fault over which each is remembered.
_MEMORY = 100.0


@dataclass(frozen=True)
class TriedResponse:
    """A response that was given to a fault.

    Attributes:
        fault: its name.
        do: the response.
        helped: whether the task went on without this fault.
    """

    fault: str
    do: Do
    helped: bool


def tried_responses(
    decisions: Sequence[tuple[str, Do]], finished: bool
) -> tuple[TriedResponse, ...]:
    """Return the responses that the decisions about one task were.

    Args:
        decisions: fault and response, in their order; what follows one shows whether it helped.
        finished: whether the task was done after the last one; if not, it is still under way, and
            whether it helped is unknown.
    """
    later = [fault for fault, _ in decisions[1:]]
    responses = [
        TriedResponse(fault, do, following != fault)
        for (fault, do), following in zip(decisions, later, strict=False)
    ]
    if decisions and finished:
        responses.append(TriedResponse(*decisions[-1], helped=True))
    return tuple(response for response in responses if not response.do.is_lasting)


class LearnedResponses:
    """What is known about all faults and responses."""

    def __init__(self, responses: Iterable[TriedResponse] = ()) -> None:
        """Take in responses, in their order."""
        self._models = {do: SuccessModel(_MEMORY) for do in Do if not do.is_lasting}
        for response in responses:
            self.learn(response)

    def learn(self, response: TriedResponse) -> None:
        """Take in a response; lasting ones are ignored."""
        if response.do not in self._models:
            return
        for do, model in self._models.items():
            if do is response.do:
                model.learn((response.fault,), response.helped)
            else:
                model.age((response.fault,))

    def belief(self, fault: str, do: Do) -> Belief:
        """Return what is believed about how often a response that is not lasting helps."""
        return self._models[do].belief((fault,), _UNKNOWN, _UNKNOWN_WEIGHT)

    def promising(self, fault: str, possible: Collection[Do]) -> frozenset[Do]:
        """Return those of the possible responses to a fault that are worth trying."""
        return frozenset(
            do
            for do in possible
            if do.is_lasting or self.belief(fault, do).interval()[1] >= LEAST_HELP
        )


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
            features: of the call, see condition.py.
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
