"""What the engine reads of a behavior's definition.

The stock classes (flexbe_core.core) are the definitions: trees of states that users write. They
hold no state of a run but what users put there. The engine has a runtime node for each state of a
run (leaf.py) and reads a definition only through these attributes:

    __kind__, execute        of the class, since the `execute` of an instance is a whole tick
    _name, _is_controlled    label in its container, or name of the behavior; whether supervised
    _rate                    see `period_s`
    _outcomes, _input_keys, _output_keys
    on_start, on_stop, on_enter, on_exit, on_pause, on_resume
  of a container also
    __holds_errors__         of the class: whether a child that raises stays active
    _labels, _transitions    label -> child, in order; label -> outcome -> label, or own outcome
    _autonomy, _remappings   label -> outcome -> level; label -> own key -> key of the container
    _own_userdata            defaults
    initial_state_label, assert_consistent_transitions()
    _conditions              of a concurrency container
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any


class Kind(Enum):
    """What a definition is; it decides which class of node runs it."""

    STATE = "state"
    MACHINE = "state machine"
    CONCURRENCY = "concurrency container"
    PRIORITY = "priority container"


# Of a concurrency container: an outcome, and the (label, outcome) pairs that bring it about.
Condition = tuple[str, Sequence[tuple[str, str]]]

# A state or a container, as its class's __kind__ says. Type checkers cannot narrow a union by such
# an attribute.
Definition = Any


# How often a state that has returned None is executed again


# [s] Stock FlexBE executes a state at 10 Hz unless it sets a rate of its own.
DEFAULT_PERIOD_S = 0.1


@dataclass(frozen=True)
class Rate:
    """A polling rate.

    Attributes:
        period_s: [s] ROS time between two executions, > 0.
    """

    period_s: float = DEFAULT_PERIOD_S

    @classmethod
    def from_hz(cls, hz: float) -> Rate:
        """Return the rate of `hz` executions per second.

        Raises:
            ValueError: if hz is not a positive number.
        """
        if not 0 < hz < float("inf"):
            raise ValueError(f"a rate must be a positive number of Hz, found {hz!r}")
        return cls(1.0 / hz)


def period_s(rate: object) -> float:
    """Return the period that a state's `_rate` asks for.

    States of stock FlexBE may put a rospy.Rate there; anything else means the default.
    """
    if isinstance(rate, Rate):
        return rate.period_s
    to_sec = getattr(getattr(rate, "sleep_dur", None), "to_sec", None)
    seconds = float(to_sec()) if to_sec is not None else 0.0
    return seconds if seconds > 0 else DEFAULT_PERIOD_S


def is_over(rate: object) -> bool:
    """Return whether the period of a rate of a user's own class, with only `remaining`, is over.

    Tests of states use such rates to have every tick execute the state.
    """
    remaining = getattr(rate, "remaining", None)
    if remaining is None or hasattr(rate, "sleep_dur"):
        return False
    return bool(remaining().to_sec() <= 0)


# The structure of a behavior as mirrors get it: its containers and states, from the outside in


@dataclass(frozen=True, slots=True)
class Part:
    """A container or state.

    Attributes:
        path: its path; empty for the root.
        children: labels of a container's children.
        outcomes: what it declares.
        transitions: where each outcome leads; empty for the root.
        autonomy: level that each outcome needs; empty for the root.
    """

    path: str
    children: tuple[str, ...]
    outcomes: tuple[str, ...]
    transitions: tuple[str, ...]
    autonomy: tuple[int, ...]


def structure_of(root: Definition) -> tuple[Part, ...]:
    """Return all parts of a definition; each container comes before its children."""
    return tuple(_walk(root, "", None, ""))


def definitions_below(root: Definition) -> Iterator[Definition]:
    """Yield the root and everything below it, depth first, in the order of definition."""
    yield root
    for child in () if type(root).__kind__ is Kind.STATE else root._labels.values():
        if type(child).__kind__ is Kind.STATE:
            yield child
        else:
            yield from definitions_below(child)


def definition_at(root: Definition, path: str) -> Definition:
    """Return the state or container at a path below the root."""
    for label in path.split("/")[1:]:
        root = root._labels[label]
    return root


def first_state(root: Definition) -> Definition:
    """Return the state that is active first; a container without states stands for itself."""
    while type(root).__kind__ is not Kind.STATE and root._labels:
        root = next(iter(root._labels.values()))
    return root


def first_path(root: Definition, path: str) -> str:
    """Return the path of the state that is active first in what is at `path`."""
    while type(root).__kind__ is not Kind.STATE and root._labels:
        label, root = next(iter(root._labels.items()))
        path = f"{path}/{label}"
    return path


def _walk(definition: Definition, path: str, parent: Definition, label: str) -> Iterator[Part]:
    is_container = type(definition).__kind__ is not Kind.STATE
    children = tuple(definition._labels) if is_container else ()
    outcomes = tuple(definition._outcomes)
    transitions = parent._transitions[label] if parent else {}
    autonomy = parent._autonomy.get(label, {}) if parent else {}
    yield Part(
        path,
        children,
        outcomes,
        tuple(transitions.get(outcome, "") for outcome in outcomes) if parent else (),
        autonomy=tuple(autonomy.get(outcome, 0) for outcome in outcomes) if parent else (),
    )
    for child in children:
        yield from _walk(definition._labels[child], f"{path}/{child}", definition, child)
