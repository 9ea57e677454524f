"""Apply commands: how each command to the active state changes the supervision."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flexbe_core.engine.events import Answered, Event, Refused
from flexbe_core.engine.supervision.commands import (
    ForceOutcome,
    Lock,
    Pause,
    Repeat,
    Resume,
    StateCommand,
    Unlock,
)
from flexbe_core.engine.supervision.in_force import Supervision

Applied = tuple[Supervision, tuple[Event, ...]]


@dataclass(frozen=True, slots=True)
class ActiveState:
    """The state to which commands apply.

    Attributes:
        name: its label; forced outcomes name it, or its path, by which the operator was asked.
        path: its path; locks name it.
        outcomes: what it declares, in order.
        ancestors: paths of the containers around it, the root's (empty) last.
    """

    name: str
    path: str
    outcomes: Sequence[str]
    ancestors: tuple[str, ...] = ()


def apply_command(supervision: Supervision, command: StateCommand, state: ActiveState) -> Applied:
    """Return the supervision after a command, and the events that answer the operator."""
    return _HANDLERS[type(command)](supervision, command, state)


def _force(supervision: Supervision, command: ForceOutcome, state: ActiveState) -> Applied:
    if command.target not in (state.name, state.path):
        answer = Answered("transition", (command.target, state.name))
        text = f"asked for an outcome of {command.target!r}, but {state.name!r} is active"
        return supervision, (answer, Refused(text))
    answer = Answered("transition", (command.target, command.target))
    if not 0 <= command.index < len(state.outcomes):
        declared = ", ".join(f"{index}: {name}" for index, name in enumerate(state.outcomes))
        text = f"asked for outcome {command.index} of {state.name!r}; it has {declared}"
        return supervision, (answer, Refused(text))
    return replace(supervision, forced=state.outcomes[command.index]), (answer,)


def _lock(supervision: Supervision, command: Lock, state: ActiveState) -> Applied:
    path = command.path or state.path
    if path != state.path and path not in state.ancestors:
        text = f"asked to lock {path!r}, which is not active; active is {state.path!r}"
        return supervision, (Answered("lock", (path, "")), Refused(text))
    return replace(supervision, locks=supervision.locks | {path}), (Answered("lock", (path, path)),)


def _unlock(supervision: Supervision, command: Unlock, state: ActiveState) -> Applied:
    path = command.path
    if not path and state.path in supervision.locks:
        path = state.path
    if path and path != state.path and path not in state.ancestors:
        text = f"asked to unlock {path!r}, which is not active; active is {state.path!r}"
        return supervision, (Answered("unlock", (path, "")), Refused(text))
    return replace(supervision, locks=supervision.locks - {path}), (
        Answered("unlock", (path, path)),
    )


def _pause(supervision: Supervision, command: Pause, state: ActiveState) -> Applied:
    return replace(supervision, paused=True), (Answered("pause"),)


def _resume(supervision: Supervision, command: Resume, state: ActiveState) -> Applied:
    return replace(supervision, paused=False), (Answered("resume"),)


def _repeat(supervision: Supervision, command: Repeat, state: ActiveState) -> Applied:
    return replace(supervision, repeat=True), (Answered("repeat"),)


_HANDLERS: dict[type, Callable[[Supervision, Any, ActiveState], Applied]] = {
    ForceOutcome: _force,
    Lock: _lock,
    Unlock: _unlock,
    Pause: _pause,
    Resume: _resume,
    Repeat: _repeat,
}
