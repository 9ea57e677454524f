"""Parameters of abilities, chosen by what recorded calls have taught.

    learned = LearnedParameters(calls)
    parameters = learned.choose("InsertCable", features, use_case.learned["InsertCable"], seed)

The same calls and the same seed give the same parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from random import Random

from remodel_planning.core.condition import Features
from remodel_planning.core.use_case.bounds import (
    Bounds,
    Setting,
    frozen_setting,
    nearer_settings,
    settings,
)
from remodel_planning.core.use_case.context import context_of
from remodel_supervision.core.learning.belief import Belief
from remodel_supervision.core.learning.learned_expectations import Call
from remodel_supervision.core.learning.parameter_choice import (
    DEFAULT_GUARD,
    GuardRail,
    ParameterChoice,
)

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
            features: of the task, see context.py.
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
        choice.learn(context_of(call.ability, call.features), setting, call.error_code == 0)
