"""A FlexBE behavior as values: what a checked chart is lowered to, and all output is made from."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

from flexbe_synthesizer.core.chart.model import Autonomy, Literal, python_literal, quick, quote
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


# The Python source that a chart may ask for: predicates by name, and none of its own.
#
# Some states of FlexBE take a function. A chart never carries code, so it names one of these.


PARAMETER = "predicate"  # the parameter of FlexBE's states that takes one
PREDICATES: Mapping[str, Expression] = {
    "is_true": Expression("lambda value: bool(value)"),
    "is_false": Expression("lambda value: not value"),
    "is_none": Expression("lambda value: value is None"),
    "is_given": Expression("lambda value: value is not None"),
    "is_empty": Expression("lambda value: len(value) < 1"),
    "is_filled": Expression("lambda value: len(value) > 0"),
    "is_positive": Expression("lambda value: value > 0"),
    "is_negative": Expression("lambda value: value < 0"),
}


def choose_by_code(routes: Iterable[tuple[str, Sequence[int]]], otherwise: str) -> Expression:
    """Return a function from an error code to the name that goes with it.

    Args:
        routes: name and codes of each route, at least one code, ascending.
        otherwise: name of all other codes, and of no code at all.
    """
    chosen = quote(otherwise)
    for name, codes in reversed(tuple(routes)):
        is_row = codes[-1] - codes[0] == len(codes) - 1
        listed = f"range({codes[0]}, {codes[-1] + 1})" if is_row else f"{tuple(codes)}"
        chosen = f"{quote(name)} if code in {listed} else {chosen}"
    return Expression(f"lambda code: {chosen}")


def is_choice_by_code(text: str, events: Iterable[str], otherwise: str) -> bool:
    """Return whether Python source is a function of `choose_by_code` with these names."""
    codes = r"(?:range\(\d+, \d+\)|\((?:\d+, )+\d+\))"
    routes = "".join(rf"{re.escape(quote(event))} if code in {codes} else " for event in events)
    return re.fullmatch(rf"lambda code: {routes}{re.escape(quote(otherwise))}", text) is not None
