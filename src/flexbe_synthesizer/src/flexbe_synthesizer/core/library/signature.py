"""What states and behaviors offer to a chart: outcomes, inputs, outputs and parameters."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from flexbe_synthesizer.core.chart.model import Chart, Literal
from flexbe_synthesizer.core.chart.names import PREEMPTED, behavior_class, behavior_module

TYPES = ("bool", "int", "float", "string", "list", "dict")
_MESSAGE = re.compile(r"[a-z][a-z0-9_]*/[A-Z][A-Za-z0-9_]*\Z")
_SOURCE = ("lambda", "function", "callable", "code")
# What state authors write in docstrings for the types of the language.
_SYNONYMS = (
    {"boolean": "bool", "str": "string", "double": "float", "integer": "int", "map": "dict"}
    | {f"{sign}int{bits}": "int" for sign in ("", "u") for bits in (8, 16, 32, 64)}
    | {f"float{bits}": "float" for bits in (32, 64)}
)


def is_type(text: str) -> bool:
    """Return whether the text is a data type of the language: a basic one or `package/Message`."""
    return text in TYPES or bool(_MESSAGE.match(text))


def documented_type(text: str) -> str | None:
    """Return the type that a state's docstring means, None for one that says nothing to us."""
    word = text.strip("`'\"()")
    word = _SYNONYMS.get(word.lower(), word)
    if word.endswith("[]"):
        return "list"
    return word if is_type(word) or word in _SOURCE else None


def fits(given: str | None, wanted: str | None) -> bool:
    """Return whether a value of one type fits another; what is no type fits all."""
    if not is_type(given or "") or not is_type(wanted or ""):
        return True
    return given == wanted or (given, wanted) == ("int", "float")


@dataclass(frozen=True)
class Port:
    """An input or output key; `optional` inputs have a default of their own."""

    name: str
    type: str | None = None
    optional: bool = False


@dataclass(frozen=True)
class Parameter:
    """A constructor argument of a state, or a parameter of a behavior.

    Attributes:
        default: a number; None for any other default.
        grace_s: [s] that a visit may last beyond this time limit.
        default_source: Python source of a default that is a literal; empty for any other.
    """

    name: str
    type: str | None = None
    required: bool = True
    default: float | None = None
    grace_s: float = 0.0
    default_source: str = ""

    @property
    def takes_source(self) -> bool:
        """Return whether the value would have to be Python source."""
        return self.type in _SOURCE


@dataclass(frozen=True)
class FromParameter:
    """A list of names that a state takes from one of its constructor arguments."""

    parameter: str


class Effect(NamedTuple):
    """Which outputs an outcome writes: `certain` in every run, `possible` in some run at least.

    What an outcome does not write keeps the value that it had, if it had one.
    """

    outcome: str
    certain: frozenset[str]
    possible: frozenset[str]


@dataclass(frozen=True)
class StateClass:
    """A state class as its source text declares it.

    Attributes:
        leaves_goals: it sends goals to abilities, and nothing in it cancels one.
        effects: what its outcomes write; one that is missing here writes all outputs.
    """

    name: str
    package: str
    module: str
    parameters: tuple[Parameter, ...]
    outcomes: tuple[str, ...] | FromParameter
    inputs: tuple[Port, ...] | FromParameter
    outputs: tuple[Port, ...] | FromParameter
    leaves_goals: bool = False
    effects: tuple[Effect, ...] = ()

    @property
    def deciding_parameters(self) -> frozenset[str]:
        """Return the parameters whose values are its outcomes or keys."""
        lists = (self.outcomes, self.inputs, self.outputs)
        return frozenset(found.parameter for found in lists if isinstance(found, FromParameter))

    @property
    def depends_on_values(self) -> bool:
        """Return whether its outcomes or keys come from the values of its parameters."""
        return bool(self.deciding_parameters)


@dataclass(frozen=True)
class BehaviorClass:
    """A behavior as its manifest and source text declare it, or as its chart does.

    Attributes:
        chart: what it is made from, if that is at hand.
    """

    name: str
    class_name: str
    package: str
    module: str
    outcomes: tuple[str, ...]
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    parameters: tuple[Parameter, ...] = ()
    contains: tuple[str, ...] = ()
    chart: Chart | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Unreadable:
    """A state class or behavior that is there but cannot be used, and why."""

    name: str
    package: str
    reason: str
    class_name: str = ""


@dataclass(frozen=True)
class Signature:
    """What a state, behavior or container of a chart offers; `title` names it in messages.

    `outcomes` is None if they depend on a parameter that is missing or wrong. An outcome without
    an effect writes all outputs.
    """

    title: str
    outcomes: tuple[str, ...] | None
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    parameters: tuple[Parameter, ...]
    effects: tuple[Effect, ...] = ()

    def effect(self, outcome: str) -> Effect | None:
        """Return what an outcome writes if that is not simply all outputs."""
        return next((effect for effect in self.effects if effect.outcome == outcome), None)


def state_signature(state: StateClass, values: Mapping[str, Literal]) -> Signature:
    """Return what a state offers when it is constructed with these values."""

    def names(declared: tuple[str, ...] | FromParameter) -> tuple[str, ...] | None:
        if not isinstance(declared, FromParameter):
            return declared
        value = values.get(declared.parameter)
        if isinstance(value, tuple) and all(isinstance(item, str) for item in value):
            return tuple(str(item) for item in value)
        return None

    def ports(declared: tuple[Port, ...] | FromParameter) -> tuple[Port, ...]:
        if not isinstance(declared, FromParameter):
            return declared
        return tuple(Port(name) for name in names(declared) or ())

    outcomes = names(state.outcomes)
    return Signature(
        f"state class {state.name}",
        None if outcomes is None else tuple(o for o in outcomes if o != PREEMPTED),
        inputs=ports(state.inputs),
        outputs=ports(state.outputs),
        parameters=state.parameters,
        effects=state.effects,
    )


def behavior_signature(behavior: BehaviorClass, effects: tuple[Effect, ...] = ()) -> Signature:
    """Return what a behavior offers whose outcomes have these effects."""
    return Signature(
        f"behavior '{behavior.name}'",
        tuple(o for o in behavior.outcomes if o != PREEMPTED),
        inputs=behavior.inputs,
        outputs=behavior.outputs,
        parameters=behavior.parameters,
        effects=effects,
    )


def chart_behavior(chart: Chart, package: str) -> BehaviorClass:
    """Return the behavior that a chart becomes in a package."""
    return BehaviorClass(
        name=chart.name,
        class_name=behavior_class(chart.name),
        package=package,
        module=f"{package}.{behavior_module(chart.name)}",
        outcomes=tuple(outcome.name for outcome in chart.outcomes),
        inputs=tuple(Port(p.name, p.type, p.default is not None) for p in chart.inputs),
        outputs=tuple(Port(p.name, p.type) for p in chart.outputs),
        chart=chart,
    )


# The state classes and behaviors that charts can name


def no_text(_behavior: BehaviorClass) -> str:
    """Return the text of the file of a behavior that has none."""
    return ""


@dataclass(frozen=True)
class Library:
    """What was found on the ROS package path, the unusable with the reason.

    Attributes:
        error_names: error codes by the names of codes and of classes of codes.
        text_of: returns the text of a behavior's file, empty if it cannot be read.
    """

    states: tuple[StateClass, ...] = ()
    behaviors: tuple[BehaviorClass, ...] = ()
    unreadable_states: tuple[Unreadable, ...] = ()
    unreadable_behaviors: tuple[Unreadable, ...] = ()
    error_names: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    text_of: Callable[[BehaviorClass], str] = field(default=no_text, compare=False, repr=False)

    def find_states(self, name: str) -> tuple[StateClass | Unreadable, ...]:
        """Return the state classes that `Class`, `package__Class` or `package/Class` means."""
        return self._states_by_name.get(name, ())

    @cached_property
    def _states_by_name(self) -> Mapping[str, tuple[StateClass | Unreadable, ...]]:
        found: dict[str, tuple[StateClass | Unreadable, ...]] = {}
        known: tuple[StateClass | Unreadable, ...] = (*self.states, *self.unreadable_states)
        for state in known:
            package, name = state.package, state.name
            for spelling in (name, f"{package}__{name}", f"{package}/{name}"):
                found[spelling] = (*found.get(spelling, ()), state)
        return found

    def find_behaviors(self, name: str) -> tuple[BehaviorClass | Unreadable, ...]:
        """Return the behaviors of that display name, else those of that class."""
        known: tuple[BehaviorClass | Unreadable, ...] = (
            *self.behaviors,
            *self.unreadable_behaviors,
        )
        return tuple(b for b in known if b.name == name) or tuple(
            b for b in known if b.class_name == name
        )

    def with_behaviors(self, behaviors: Iterable[BehaviorClass]) -> Library:
        """Return the library with these behaviors in place of those of the same module."""
        new = tuple(behaviors)
        modules = {behavior.module for behavior in new}
        names = {(behavior.package, behavior.name) for behavior in new}
        return replace(
            self,
            behaviors=(*(b for b in self.behaviors if b.module not in modules), *new),
            unreadable_behaviors=tuple(
                b for b in self.unreadable_behaviors if (b.package, b.name) not in names
            ),
        )
