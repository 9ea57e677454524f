"""A FlexBE behavior as values: what a checked chart is lowered to, and all output is made from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

from flexbe_synthesizer.core.chart.literal import Literal, python_literal
from flexbe_synthesizer.core.chart.model import Autonomy
from flexbe_synthesizer.core.chart.quick import quick
from flexbe_synthesizer.core.library.signature import BehaviorClass, StateClass


class Kind(Enum):
    """How a container runs what is in it."""

    STATE_MACHINE = "OperatableStateMachine"
    CONCURRENCY = "ConcurrencyContainer"
    PRIORITY = "PriorityContainer"


class Exit(NamedTuple):
    """Where an outcome of a child leads; `autonomy` None means the default of its kind."""

    outcome: str
    target: str
    autonomy: Autonomy | None = None


class Condition(NamedTuple):
    """An outcome of a concurrency container, and the outcomes of children that cause it together.

    `pairs` holds (child, outcome).
    """

    outcome: str
    pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Expression:
    """A Python expression of our own making; nothing that a chart says becomes one."""

    text: str


Value: TypeAlias = "Literal | Expression"


class Pair(NamedTuple):
    """A name and what belongs to it: a parameter and its value, a key and its default."""

    name: str
    value: Value


def python_value(value: Value) -> str:
    """Return the Python expression for a value."""
    return value.text if isinstance(value, Expression) else python_literal(value)


@quick
@dataclass(frozen=True, slots=True)
class StateUse:
    """A state as the content of a child; `alias` is the name that it is imported under."""

    state: StateClass
    alias: str
    arguments: tuple[Pair, ...]


@dataclass(frozen=True, slots=True)
class BehaviorUse:
    """A behavior as the content of a child; `defaulted` inputs keep the behavior's own default."""

    behavior: BehaviorClass
    parameters: tuple[Pair, ...]
    defaulted: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Container:
    """A container of FlexBE; its first child is the initial one.

    Attributes:
        userdata: default userdata, in order.
        conditions: of a concurrency container only.
    """

    kind: Kind
    outcomes: tuple[str, ...]
    input_keys: tuple[str, ...]
    output_keys: tuple[str, ...]
    children: tuple[Child, ...]
    userdata: tuple[Pair, ...] = ()
    conditions: tuple[Condition, ...] = ()


@quick
@dataclass(frozen=True, slots=True)
class Child:
    """A labelled element of a container; `remapping` maps own keys to the container's."""

    label: str
    content: StateUse | BehaviorUse | Container
    exits: tuple[Exit, ...]
    remapping: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Machine:
    """A whole behavior: its names, its root container, and what its manifest says besides."""

    name: str
    package: str
    description: str
    root: Container
    author: str = ""
    tags: str = ""


def walk(container: Container, path: str = "") -> Iterator[tuple[str, Child]]:
    """Yield every child below a container with its path, such as `/Insert/run`."""
    waiting = [(path, iter(container.children))]
    while waiting:
        above, children = waiting[-1]
        for child in children:
            own_path = f"{above}/{child.label}"
            yield own_path, child
            if isinstance(child.content, Container):
                waiting.append((own_path, iter(child.content.children)))
                break
        else:
            waiting.pop()
