"""What the engine reads of a behavior's definition.

The stock classes (flexbe_core.core) are the definitions: trees of states that users write. They
hold no state of a run but what users put there. The engine has a runtime node for each state of a
run (node.py) and reads a definition only through the attributes below.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Any, Protocol

from flexbe_core.engine.userdata.user_data import UserData


class Kind(Enum):
    """What a definition is; it decides which class of node runs it."""

    STATE = "state"
    MACHINE = "state machine"
    CONCURRENCY = "concurrency container"
    PRIORITY = "priority container"


class StateDefinition(Protocol):
    """A state as users define it.

    Attributes:
        __kind__: what it is; looked up on the class.
        _name: its label in its container; of a root, the behavior's name.
        _is_controlled: whether an operator supervises it.
        _rate: a rate object, see rate.period_s.
        execute: looked up on the class, since the attribute of the instance is a whole tick.
    """

    __kind__: Kind
    _name: str | None
    _outcomes: list[str]
    _input_keys: list[str]
    _output_keys: list[str]
    _is_controlled: bool
    _rate: object
    execute: Callable[..., str | None]

    def on_start(self) -> None:
        """Prepare, once per run."""

    def on_stop(self) -> None:
        """Clean up, once per run."""

    def on_enter(self, userdata: UserData) -> None:
        """Begin a visit."""

    def on_exit(self, userdata: UserData) -> None:
        """End a visit."""

    def on_pause(self) -> None:
        """Stop for a while."""

    def on_resume(self, userdata: UserData) -> None:
        """Go on."""


class ContainerDefinition(StateDefinition, Protocol):
    """A container as users define it.

    Attributes:
        __holds_errors__: whether a child that raises stays active; looked up on the class.
        _labels: label -> child, in the order of definition.
        _transitions: label -> outcome -> label or outcome of the container.
        _autonomy: label -> outcome -> required level.
        _remappings: label -> own key -> key of the container.
        _own_userdata: defaults.
    """

    __holds_errors__: bool
    _labels: Mapping[str, Any]
    _transitions: Mapping[str, Mapping[str, str]]
    _autonomy: Mapping[str, Mapping[str, int]]
    _remappings: Mapping[str, Mapping[str, str]]
    _own_userdata: UserData

    @property
    def initial_state_label(self) -> str:
        """The child that begins."""

    def assert_consistent_transitions(self) -> None:
        """Raise StateMachineError if a transition leads nowhere."""


Condition = tuple[str, Sequence[tuple[str, str]]]


class ConcurrencyDefinition(ContainerDefinition, Protocol):
    """A concurrency container: outcome, and the (label, outcome) pairs that bring it about."""

    _conditions: Sequence[Condition]


# A StateDefinition or a ContainerDefinition, as its class's __kind__ says. Type checkers cannot
# narrow a union by such an attribute.
Definition = Any
