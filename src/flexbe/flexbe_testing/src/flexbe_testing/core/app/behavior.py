"""A behavior as the App holds it after loading, and the states and behaviors that it knows."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from flexbe_testing.core.app.states import FromParameter, Names, StateDefinition, without_blanks
from flexbe_testing.core.app.text import names

Point = tuple[int, int]
OFF, INHERIT = "Autonomy.Off", "Autonomy.Inherit"
_LEVEL = re.compile(r"Autonomy\.(Off|Low|High|Full|Inherit)|-?\d+")


@dataclass(frozen=True)
class BehaviorDefinition:
    """What the App knows of a behavior that others can contain."""

    name: str
    class_name: str
    module: str
    outcomes: tuple[str, ...] = ()
    input_keys: tuple[str, ...] = ()
    output_keys: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True)
class StateUse:
    """A state with the values of its parameters that its call gives, as text by name."""

    definition: StateDefinition
    given: Mapping[str, str]

    def value(self, parameter: str) -> str:
        """Return a value, given or default; empty if there is none, or if an empty one is given."""
        return self.given.get(parameter, self.definition.parameters.get(parameter) or "")

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the outcomes, without blanks."""
        return tuple(map(without_blanks, self._names(self.definition.outcomes)))

    @property
    def input_keys(self) -> tuple[str, ...]:
        """Return the keys that it reads."""
        return self._names(self.definition.input_keys)

    @property
    def output_keys(self) -> tuple[str, ...]:
        """Return the keys that it writes."""
        return self._names(self.definition.output_keys)

    def _names(self, declared: Names) -> tuple[str, ...]:
        if isinstance(declared, FromParameter):
            return tuple(names(self.value(declared.parameter)) or ())
        return declared


@dataclass(frozen=True)
class BehaviorUse:
    """A contained behavior; `keys_by_default` are inputs that keep their own default."""

    definition: BehaviorDefinition
    id: str
    keys_by_default: tuple[str, ...] = ()
    given: Mapping[str, str] = field(default_factory=dict)

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the outcomes."""
        return self.definition.outcomes

    @property
    def input_keys(self) -> tuple[str, ...]:
        """Return the keys that must be fed."""
        return tuple(k for k in self.definition.input_keys if k not in self.keys_by_default)

    @property
    def output_keys(self) -> tuple[str, ...]:
        """Return the keys that it writes."""
        return self.definition.output_keys


@dataclass(frozen=True)
class Container:
    """A container of states; `kind` is the class that the file constructs."""

    kind: str
    outcomes: tuple[str, ...]
    input_keys: tuple[str, ...]
    output_keys: tuple[str, ...]
    places: tuple[Point, ...]
    conditions: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()
    children: tuple[Child, ...] = ()

    @property
    def is_concurrent(self) -> bool:
        """Return whether all children run at once."""
        return self.kind == "ConcurrencyContainer"


@dataclass(frozen=True)
class Child:
    """A state, behavior or container in a container."""

    label: str
    place: Point
    content: StateUse | BehaviorUse | Container
    transitions: Mapping[str, str]
    autonomy: Mapping[str, str]
    remapping: Mapping[str, str]

    @property
    def keys(self) -> tuple[str, ...]:
        """Return all keys, inputs first."""
        return tuple(dict.fromkeys((*self.content.input_keys, *self.content.output_keys)))

    def level(self, outcome: str) -> str:
        """Return the autonomy that an outcome needs."""
        default = OFF if isinstance(self.content, StateUse) else INHERIT
        level = self.autonomy.get(outcome, default)
        return level if _LEVEL.fullmatch(level) else INHERIT


@dataclass(frozen=True)
class AppBehavior:
    """A loaded behavior.

    Attributes:
        lost: complaints about what the App does not take from the file; it is gone once saved.
    """

    name: str
    class_name: str
    description: str
    author: str
    date: str
    parameters: Mapping[str, str]
    notes: str
    private: Mapping[str, str]
    userdata: Mapping[str, str]
    manual: Mapping[str, str]
    root: Container
    lost: tuple[str, ...] = field(default=(), compare=False)


def walk(container: Container, path: str = "") -> Iterator[tuple[str, Child]]:
    """Yield all children with their paths, those of a container after it."""
    for child in container.children:
        inner = f"{path}/{child.label}"
        yield inner, child
        if isinstance(child.content, Container):
            yield from walk(child.content, inner)


# The states and behaviors that the App knows, and which of them a name means


class Known:
    """What the App found in the packages of a workspace."""

    def __init__(
        self,
        states: Iterable[StateDefinition] = (),
        behaviors: Iterable[BehaviorDefinition] = (),
    ) -> None:
        """Know these states and behaviors, in this order."""
        self.states = tuple(states)
        self.behaviors = tuple(behaviors)

    def behavior(self, class_name: str) -> BehaviorDefinition | None:
        """Return the behavior of a class."""
        return next((b for b in self.behaviors if b.class_name == class_name), None)

    def state(self, alias: str, used: Collection[str]) -> StateDefinition | None:
        """Return the state of a name in a file: `Class`, or `package__Class`.

        Args:
            alias: the name.
            used: outcomes, without blanks, which distinguish states of one class name.
        """
        package, separator, name = alias.partition("__")
        if separator:
            found = [s for s in self.states if (s.package, s.class_name) == (package, name)]
            return found[0] if found else None
        found = [s for s in self.states if s.class_name == alias]
        covering = [s for s in found if _covers(s, used)] if len(found) > 1 else found
        return covering[0] if covering else None

    def alias(self, state: StateDefinition) -> str:
        """Return the name that the App gives to a state when it saves a behavior."""
        is_unique = self._counts[state.class_name] == 1
        return state.class_name if is_unique else f"{state.package}__{state.class_name}"

    @cached_property
    def _counts(self) -> Counter[str]:
        return Counter(state.class_name for state in self.states)


def _covers(state: StateDefinition, used: Collection[str]) -> bool:
    return isinstance(state.outcomes, FromParameter) or set(used) <= set(state.outcomes)
