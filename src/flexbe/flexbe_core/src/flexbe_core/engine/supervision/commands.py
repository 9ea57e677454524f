"""What an operator may ask of a running behavior, as values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Preempt:
    """Stop the behavior."""


@dataclass(frozen=True, slots=True)
class SetAutonomy:
    """Take transitions that need less than `level` without asking the operator."""

    level: int


@dataclass(frozen=True, slots=True)
class Attach:
    """Supervise the behavior from now on, at `level`."""

    level: int


@dataclass(frozen=True, slots=True)
class Sync:
    """Publish the active state for mirrors."""


@dataclass(frozen=True, slots=True)
class ShowStructure:
    """Publish the behavior's structure for mirrors; operators supervise it from now on."""


@dataclass(frozen=True, slots=True)
class ShowValues:
    """Publish the active state with its values, for a node that has just subscribed."""


@dataclass(frozen=True, slots=True)
class ForceOutcome:
    """Take the outcome with this index in the active state, if `target` is its name."""

    target: str
    index: int


@dataclass(frozen=True, slots=True)
class Lock:
    """Do not leave the state or container at `path`; empty is the active state."""

    path: str


@dataclass(frozen=True, slots=True)
class Unlock:
    """End a lock; empty is the active state."""

    path: str


@dataclass(frozen=True, slots=True)
class Pause:
    """Execute nothing until resumed."""


@dataclass(frozen=True, slots=True)
class Resume:
    """Continue after a pause."""


@dataclass(frozen=True, slots=True)
class Repeat:
    """Leave the active state and enter it again."""


@dataclass(frozen=True, slots=True)
class Release:
    """Detach the active state, for another version of the behavior, and end the run.

    Attributes:
        offer: called with the active state (None if there is none); returns whether the other
            version has attached it. If not, the run continues.
    """

    offer: Callable[[Any], bool]


StateCommand = ForceOutcome | Lock | Unlock | Pause | Resume | Repeat
Command = (
    Preempt | SetAutonomy | Attach | Sync | ShowStructure | ShowValues | Release | StateCommand
)
