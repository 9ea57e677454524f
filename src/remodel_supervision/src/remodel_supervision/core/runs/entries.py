"""Entries of a run's record that take more than a line, and the helpers that make the others.

Positions and times are added by `entries_of`, which reads the table of events.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from remodel_run.record import Entry, Kind
from remodel_run.whole_task import counted
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs import events
from remodel_supervision.core.runs.attempts import Attempts
from remodel_supervision.core.runs.events import AsLeft

_NAME = re.compile(r".*_(?P<stamp>\d+\.\d{3})_(?P<camera>[a-z]+)\.jpg")


def picture_name(label: str, stamp_s: float, camera: str) -> str:
    """Return a file name."""
    return f"{label}_{stamp_s:.3f}_{camera}.jpg"


def seen_by(name: str) -> tuple[str, float]:
    """Return the camera and the time [s] of a picture, by its file's name.

    Raises:
        ValueError: if it is no such name.
    """
    found = _NAME.fullmatch(name)
    if found is None:
        raise ValueError(f"{name!r} is no name of a run's picture")
    return found["camera"], float(found["stamp"])


# Units of what operations measure, by the name of the result's field.
_UNITS = {"depth": "m", "peak_force": "n", "slip": "m", "residual": "m", "travelled": "m"}
_AS_LEFT = {
    AsLeft.RUNNING: "has it",
    AsLeft.DONE: "has done it",
    AsLeft.SET_ASIDE: "has skipped it",
}


def of_run(text: str, because: str = "") -> list[Entry]:
    """Return the entry of what is about the run."""
    return [Entry(0, 0.0, Kind.RUN, text=text, because=because)]


def of_task(task: str, text: str, code: int = 0) -> list[Entry]:
    """Return the entry of what is about a task."""
    return [Entry(0, 0.0, Kind.TASK, task, text=text, error_code=code)]


def of_decision(
    task: str, text: str, because: str, values: tuple[tuple[str, float], ...] = ()
) -> list[Entry]:
    """Return the entry of what was decided."""
    return [Entry(0, 0.0, Kind.DECISION, task, text=text, because=because, values=values)]


def of_operator(task: str, text: str, by: str = "") -> list[Entry]:
    """Return the entry of what an operator was asked, or has asked for."""
    return [Entry(0, 0.0, Kind.OPERATOR, task, text=text, because=by)]


def task_begun(event: events.TaskBegun, _: Attempts) -> list[Entry]:
    """Return the beginning of a behavior, with what learning chose for it."""
    learned = [f"{each.parameter} {each.value:g} at {each.step}" for each in event.chosen]
    text = ", ".join([f"attempt {event.attempt}: {event.part.value}", *learned])
    return [Entry(0, 0.0, Kind.TASK, event.task, behavior=event.behavior, text=text)]


def task_ended(event: events.TaskEnded, so_far: Attempts) -> list[Entry]:
    """Return what a behavior did, with its pictures, in the order of time, and how it ended."""
    behavior = so_far.behavior
    pictures = (_picture(event.task, behavior, name) for name in event.pictures)
    entries = sorted((*_operations(so_far), *pictures), key=lambda entry: entry.time_s)
    left = Entry(0, 0.0, Kind.STATE, event.task, behavior=behavior)
    return [*entries, left, *of_task(event.task, event.outcome)]


def interrupted(event: events.Interrupted, so_far: Attempts) -> list[Entry]:
    """Return what the behavior that was cut off had done."""
    return [*_operations(so_far), *of_run(f"interrupted: {event.because}")]


def stop_reported(event: events.StopReported, so_far: Attempts) -> list[Entry]:
    """Return the operation that was reported late."""
    return list(_operation(event.task, so_far.behavior, event.operation))


def settled(event: events.Settled, _: Attempts) -> list[Entry]:
    """Return what an inspection found."""
    if event.unseen:
        return of_task(event.task, f"the inspection failed: {event.unseen}", event.code)
    ends = " and ".join(f"end {letter}" for letter in event.connected)
    left = f"{counted(event.left, 'step')} left" if event.left else "it is done"
    seen = f"{ends} connected" if event.connected else "no end in"
    return of_task(event.task, f"inspected: {seen}; {left}", event.code)


def decided(event: events.Decided, _: Attempts) -> list[Entry]:
    """Return a failure, and what was decided about it."""
    failure = Entry(
        0,
        0.0,
        Kind.FAILURE,
        event.task,
        state_path=event.state_path,
        ability=event.ability,
        fault=event.fault,
        error_code=event.code,
        text=event.text,
    )
    return [failure, *of_decision(event.task, event.do.value, event.because, event.change)]


def task_elsewhere(event: events.TaskElsewhere, _: Attempts) -> list[Entry]:
    """Return what another cell has done with a task."""
    cell = f"cell {event.cell}" if event.cell else "another cell"
    return of_task(event.task, f"{cell} {_AS_LEFT[event.as_left]}")


def _operations(so_far: Attempts) -> Iterator[Entry]:
    if so_far.begun is not None:
        for operation in so_far.operations:
            yield from _operation(so_far.begun.task, so_far.behavior, operation)


def _operation(task: str, behavior: str, operation: Operation) -> Iterator[Entry]:
    about = (task, behavior, operation.state_path, operation.ability)
    begun_s = max(0.0, operation.ended_s - operation.elapsed_s)
    yield Entry(0, begun_s, Kind.STATE, *about)
    yield Entry(
        0,
        operation.ended_s,
        Kind.RESULT,
        *about,
        error_code=operation.error_code,
        text=operation.text,
        values=tuple(_numbers(operation.measurements)),
    )


def _picture(task: str, behavior: str, name: str) -> Entry:
    camera, time_s = seen_by(name)
    return Entry(
        0,
        time_s,
        Kind.PICTURE,
        task,
        behavior=behavior,
        text=camera,
        because=name,
        has_picture=True,
    )


def _numbers(pairs: Iterable[tuple[str, str]]) -> Iterator[tuple[str, float]]:
    for name, value in pairs:
        try:
            number = float(value)
        except ValueError:
            continue
        yield (f"{name}_{_UNITS[name]}" if name in _UNITS else name), number
