"""A run's state as plain data, and back: a snapshot, from which a long run is resumed.

The events remain what is true: a snapshot that was made by another version of the state is not
read, and the state is computed from all events.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from functools import cache

import msgspec

from remodel_run.progress import HandWire
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Asked, Decided, RunEnded
from remodel_supervision.core.runs.state import RunState, Stage, TaskProgress

# To be increased when the fold gives other values to the same fields.
_FOLD = 5
_PARTS = (RunState, TaskProgress, Operation, Decided, Asked, RunEnded, HandWire)
_FORM, _STATE, _TASKS = "form", "state", "tasks"


def snapshot_of(state: RunState) -> dict[str, object]:
    """Return a state as plain data, for JSON.

    The operations of tasks that are done are left out: nothing depends on them any more.
    """
    tasks = [_sparse(_without_operations(task)) for task in state.tasks.values()]
    rest = dataclasses.replace(state, tasks={})
    return {_FORM: _form(), _STATE: _sparse(rest), _TASKS: tasks}


def state_from(data: object) -> RunState | None:
    """Return the state of a snapshot; None if this version of the program did not make it."""
    if not isinstance(data, Mapping) or data.get(_FORM) != _form():
        return None
    try:
        tasks = msgspec.convert(data[_TASKS], tuple[TaskProgress, ...])
        rest = msgspec.convert(data[_STATE], RunState)
    except (KeyError, msgspec.ValidationError):
        return None
    return dataclasses.replace(rest, tasks={task.name: task for task in tasks})


def _without_operations(task: TaskProgress) -> TaskProgress:
    if task.stage is Stage.DONE and task.operations:
        return dataclasses.replace(task, operations=())
    return task


def _sparse(value: RunState | TaskProgress) -> dict[str, object]:
    """Return the fields that differ from their defaults."""
    kind: type = type(value)
    return {
        name: msgspec.to_builtins(item)
        for name, default in _defaults(kind)
        if (item := getattr(value, name)) != default
    }


@cache
def _defaults(kind: type) -> tuple[tuple[str, object], ...]:
    pairs: list[tuple[str, object]] = []
    for each in dataclasses.fields(kind):
        make = each.default_factory
        pairs.append((each.name, each.default if make is dataclasses.MISSING else make()))
    return tuple(pairs)


def _default_of(each: dataclasses.Field[object]) -> str:
    return "none" if each.default is dataclasses.MISSING else repr(each.default)


@cache
def _form() -> str:
    """Return what identifies this version of the state: its fields, their types and defaults."""
    text = "; ".join(
        f"{part.__name__}.{each.name}: {each.type} = {_default_of(each)}"
        for part in _PARTS
        for each in dataclasses.fields(part)
    )
    return f"{_FOLD}-{hashlib.sha256(text.encode()).hexdigest()[:16]}"
