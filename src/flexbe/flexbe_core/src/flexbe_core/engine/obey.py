"""How each command to the active state changes the supervision record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flexbe_core.engine.commands import (
    ForceOutcome,
    Lock,
    Pause,
    Repeat,
    Resume,
    StateCommand,
    Unlock,
)
from flexbe_core.engine.facts import Answered, Fact, Refused
from flexbe_core.engine.supervision import Supervision

Obedience = tuple[Supervision, tuple[Fact, ...]]


@dataclass(frozen=True, slots=True)
class ActiveState:
    """The state that commands are about.

    Attributes:
        name: its label; forced outcomes name it.
        path: its path; locks name it.
        outcomes: what it declares, in order.
        ancestors: paths of the containers around it, the root's (empty) last.
    """

    name: str
    path: str
    outcomes: Sequence[str]
    ancestors: tuple[str, ...] = ()


def obey(record: Supervision, command: StateCommand, state: ActiveState) -> Obedience:
    """Return the record after a command, and what to tell the operator."""
    return _HANDLERS[type(command)](record, command, state)


def _force(record: Supervision, command: ForceOutcome, state: ActiveState) -> Obedience:
    answer = Answered("transition", (command.target, state.name))
    if command.target != state.name:
        text = f"asked for an outcome of {command.target!r}, but {state.name!r} is active"
        return record, (answer, Refused(text))
    if not 0 <= command.index < len(state.outcomes):
        declared = ", ".join(f"{index}: {name}" for index, name in enumerate(state.outcomes))
        text = f"asked for outcome {command.index} of {state.name!r}; it has {declared}"
        return record, (answer, Refused(text))
    return replace(record, forced=state.outcomes[command.index]), (answer,)


def _lock(record: Supervision, command: Lock, state: ActiveState) -> Obedience:
    path = command.path or state.path
    if path != state.path and path not in state.ancestors:
        text = f"asked to lock {path!r}, which is not active; active is {state.path!r}"
        return record, (Answered("lock", (path, "")), Refused(text))
    return replace(record, locks=record.locks | {path}), (Answered("lock", (path, path)),)


def _unlock(record: Supervision, command: Unlock, state: ActiveState) -> Obedience:
    path = command.path
    if not path and state.path in record.locks:
        path = state.path
    if path and path != state.path and path not in state.ancestors:
        text = f"asked to unlock {path!r}, which is not active; active is {state.path!r}"
        return record, (Answered("unlock", (path, "")), Refused(text))
    return replace(record, locks=record.locks - {path}), (Answered("unlock", (path, path)),)


def _pause(record: Supervision, command: Pause, state: ActiveState) -> Obedience:
    return replace(record, paused=True), (Answered("pause"),)


def _resume(record: Supervision, command: Resume, state: ActiveState) -> Obedience:
    return replace(record, paused=False), (Answered("resume"),)


def _repeat(record: Supervision, command: Repeat, state: ActiveState) -> Obedience:
    return replace(record, repeat=True), (Answered("repeat"),)


_HANDLERS: dict[type, Callable[[Supervision, Any, ActiveState], Obedience]] = {
    ForceOutcome: _force,
    Lock: _lock,
    Unlock: _unlock,
    Pause: _pause,
    Resume: _resume,
    Repeat: _repeat,
}
