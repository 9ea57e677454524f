"""A recorded run as text: what was done, what failed, what was decided about it and why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime

from remodel_planner.core.reports.run_report import failure_line
from remodel_planning.core.use_case.fault import FaultTable
from remodel_run.progress import sums_words
from remodel_supervision.core.run import Execution
from remodel_supervision.core.runs.attempts import INTERRUPTED, attempts_of
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    AsLeft,
    Blocked,
    Commanded,
    Decided,
    Escalated,
    Event,
    FeedRefused,
    Interrupted,
    Planned,
    RunEnded,
    Settled,
    StopReported,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_supervision.core.runs.fold import state_after
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.core.runs.sums import sums_of


def explain_run(
    number: int, begun: datetime, events: Sequence[Event], faults: FaultTable
) -> Iterator[str]:
    """Yield the explanation of a run, line by line.

    Args:
        number: of the run.
        begun: wall time, UTC.
        events: of the run, in order.
        faults: with their symptoms.
    """
    state = state_after(events)
    sums = sums_of(state)
    attempts = list(attempts_of(events))
    yield (
        f"run {number} of order {state.order} in cell {state.cell}, begun "
        f"{begun:%Y-%m-%d %H:%M:%S} UTC: {_count(sums.tasks, 'task')}, "
        f"{_count(len(attempts), 'behavior')}"
    )
    for event in events:
        if isinstance(event, TaskEnded):
            yield from _ended(attempts.pop(0).execution)
        elif isinstance(event, Interrupted):
            if attempts and attempts[0].execution.outcome == INTERRUPTED:
                yield from _ended(attempts.pop(0).execution)
            yield f"interrupted: {event.because}"
        elif isinstance(event, Decided):
            symptoms = faults[event.fault].symptoms if event.fault in faults.names else ""
            yield f"    it was {event.fault}. {symptoms}".rstrip()
            yield f"    so: {event.do.value.replace('_', ' ')}, since {event.because}"
            for name, value in event.change:
                yield f"    with {name} {value:g}"
        else:
            yield from _lines(event)
    left = [name for name, task in state.tasks.items() if task.stage is not Stage.DONE]
    end = f"not done: {' '.join(left)}" if left else "all are done"
    yield f"{sums_words(sums)}; {end}"


def _ended(execution: Execution) -> Iterator[str]:
    yield (
        f"{execution.wire}, attempt {execution.attempt}: {execution.behavior} ended "
        f"{execution.outcome} after {execution.cell_s:.1f} s and "
        f"{_count(len(execution.operations), 'operation')}"
    )
    for failure in execution.failures:
        yield f"    {failure.state_path}: {failure_line(failure)}"
        for how, pairs in (("asked for", failure.parameters), ("found", failure.measurements)):
            if pairs:
                yield f"        {how}: {', '.join(f'{name} {value}' for name, value in pairs)}"
    if execution.failures and execution.outcome == "finished":
        yield "    the behavior recovered by itself"


def _lines(event: Event) -> Iterator[str]:
    """Yield the lines about an event that stands alone; of most, none."""
    match event:
        case Planned():
            yield f"planned, since {event.because}: {' '.join(event.tasks)}"
        case TaskBegun():
            for chosen in event.chosen:
                yield (
                    f"{event.task}, attempt {event.attempt}: {chosen.step} with "
                    f"{chosen.parameter} {chosen.value:g}, chosen by learning"
                )
        case Settled():
            yield _inspection(event)
        case StopReported():
            operation = event.operation
            yield f"{event.task}: {operation.state_path} had ended: {failure_line(operation)}"
        case Asked():
            choices = ", ".join(choice.value for choice in event.choices)
            yield f"question {event.number}: {event.text} ({choices})"
        case Answered():
            yield f"{event.by} answered {event.choice.value} to question {event.number}"
        case Escalated():
            response = event.do.value.replace("_", " ")
            yield f"no answer to question {event.number} in time: {response}"
        case FeedRefused():
            yield f"{event.task}: no piece was presented: error {event.code}: {event.text}"
        case Commanded():
            command = event.command.value.replace("_", " ")
            yield f"{event.by} asked for: {command} {event.task}".rstrip()
        case TaskElsewhere():
            cell = f"cell {event.cell}" if event.cell else "another cell"
            is_running = event.as_left is AsLeft.RUNNING
            how = "has it" if is_running else f"has left it {event.as_left.value}"
            yield f"{event.task}: {cell} {how}"
        case TaskReturned():
            yield f"{event.task}: taken over from cell {event.cell}, which began it and went silent"
        case Blocked():
            yield f"it cannot go on: {event.because}"
        case RunEnded():
            # What ended a run early is reported in full where it happened.
            because, *_ = event.because.split("\n")
            yield f"ended {event.ending.value}: {because}"


def _inspection(event: Settled) -> str:
    if event.unseen:
        return f"{event.task}: the inspection failed: {event.unseen}"
    seen = f"end {' and end '.join(event.connected)} connected" if event.connected else "no end in"
    left = f"{_count(event.left, 'step')} left" if event.left else "it is done"
    return f"{event.task}: inspected: {seen}; {left}"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
