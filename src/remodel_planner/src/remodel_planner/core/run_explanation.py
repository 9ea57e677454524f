"""A recorded run as text: what was done, what failed, what was decided about it and why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime

from remodel_planner.core.run_report import failure_line
from remodel_run.progress import sums_words
from remodel_run.record import entry_words
from remodel_run.whole_task import counted
from remodel_supervision.core.run import Execution
from remodel_supervision.core.runs import events
from remodel_supervision.core.runs.attempts import INTERRUPTED
from remodel_supervision.core.runs.event_table import attempts_of, entries_of, state_after
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.core.runs.sums import sums_of
from remodel_tasks.core.use_case.fault import FaultTable

# What goes as it should needs no explanation.
_ROUTINE = (events.RunBegun, events.PanelLoaded, events.PartRequested, events.OperationEnded)


def explain_run(
    number: int, begun: datetime, happened: Sequence[Event], faults: FaultTable
) -> Iterator[str]:
    """Yield the explanation of a run, line by line.

    Args:
        number: of the run.
        begun: wall time, UTC.
        happened: of the run, in order.
        faults: with their symptoms.
    """
    state = state_after(happened)
    sums = sums_of(state)
    attempts = list(attempts_of(happened))
    yield (
        f"run {number} of order {state.order} in cell {state.cell}, begun "
        f"{begun:%Y-%m-%d %H:%M:%S} UTC: {counted(sums.tasks, 'task')}, "
        f"{counted(len(attempts), 'behavior')}"
    )
    for event in happened:
        if isinstance(event, events.TaskEnded):
            yield from _ended(attempts.pop(0).execution)
        elif isinstance(event, events.Interrupted):
            if attempts and attempts[0].execution.outcome == INTERRUPTED:
                yield from _ended(attempts.pop(0).execution)
            yield from _lines(event)
        elif isinstance(event, events.Decided):
            symptoms = faults[event.fault].symptoms if event.fault in faults.names else ""
            yield f"    it was {event.fault}. {symptoms}".rstrip()
            _, decision = entries_of([event])
            yield f"    {entry_words(decision)}"
            for name, value in event.change:
                yield f"    with {name} {value:g}"
        elif isinstance(event, events.StopReported):
            operation = event.operation
            yield f"{event.task}: {operation.state_path} had ended: {failure_line(operation)}"
        elif not _is_routine(event):
            yield from _lines(event)
    left = [name for name, task in state.tasks.items() if task.stage is not Stage.DONE]
    end = f"not done: {' '.join(left)}" if left else "all are done"
    yield f"{sums_words(sums)}; {end}"


def _ended(execution: Execution) -> Iterator[str]:
    yield (
        f"{execution.wire}, attempt {execution.attempt}: {execution.behavior} ended "
        f"{execution.outcome} after {execution.cell_s:.1f} s and "
        f"{counted(len(execution.operations), 'operation')}"
    )
    for failure in execution.failures:
        yield f"    {failure.state_path}: {failure_line(failure)}"
        for how, pairs in (("asked for", failure.parameters), ("found", failure.measurements)):
            if pairs:
                yield f"        {how}: {', '.join(f'{name} {value}' for name, value in pairs)}"
    if execution.failures and execution.outcome == "finished":
        yield "    the behavior recovered by itself"


def _is_routine(event: Event) -> bool:
    has_learned = isinstance(event, events.TaskBegun) and event.chosen
    return isinstance(event, (*_ROUTINE, events.TaskBegun)) and not has_learned


def _lines(event: Event) -> Iterator[str]:
    """Yield what the record says about an event that stands alone."""
    for entry in entries_of([event]):
        words = entry_words(entry)
        if isinstance(event, events.RunEnded):  # in full where it happened
            words, *_ = words.split("\n")
        yield f"{entry.task}: {words}" if entry.task else words
