"""What each event of a run means: how it changes the state, how it reads, what it counts for.

One row for each kind of event, and the views of a run that follow from the rows: its state, the
entries of its record, its behaviors, and whether it follows from what was before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from remodel_run.record import Entry
from remodel_supervision.core.runs import entries, events, transitions
from remodel_supervision.core.runs.attempts import Attempt, Attempts
from remodel_supervision.core.runs.entries import of_decision, of_operator, of_run, of_task
from remodel_supervision.core.runs.events import Event, Part
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.core.runs.step import (
    Ask,
    Decide,
    EndRun,
    Execute,
    Plan,
    Settle,
    next_step,
)
from remodel_supervision.core.runs.sums import begun_words

E = TypeVar("E")


@dataclass(frozen=True)
class Meaning:
    """What one kind of event means.

    Attributes:
        change: returns the state after it.
        reads: returns its entries in the record of the run, which a person reads.
        differs: returns how it differs from what the state before it asked for, empty if it does
            not; None: it may happen at any time.
        counts: takes it in as what it counts for among the behaviors of the run; None: nothing.
    """

    change: Callable[[Any, RunState], RunState]
    reads: Callable[[Any, Attempts], Iterable[Entry]]
    differs: Callable[[Any, RunState], str] | None
    counts: Callable[[Attempts, Any], None] | None


def _row(
    kind: type[E],
    change: Callable[[E, RunState], RunState],
    reads: Callable[[E, Attempts], Iterable[Entry]],
    differs: Callable[[E, RunState], str] | None = None,
    counts: Callable[[Attempts, E], None] | None = None,
) -> tuple[type[E], Meaning]:
    return kind, Meaning(change, reads, differs, counts)


def _is_first(_: events.RunBegun, state: RunState) -> str:
    return "" if state == RunState() else "a run begins once"


def _is_under_way(event: events.OperationEnded | events.TaskEnded, state: RunState) -> str:
    task = state.tasks.get(event.task)
    is_running = task is not None and task.stage is Stage.RUNNING
    return "" if is_running else f"{event.task} was not under way"


def _is_requested(event: events.FeedRefused, state: RunState) -> str:
    task = state.tasks.get(event.task)
    is_requested = task is not None and task.name == state.current and task.piece
    return "" if is_requested else f"no piece of {event.task} was asked for"


def _is_open(event: events.Escalated, state: RunState) -> str:
    asked = state.question
    is_open = asked is not None and (asked.number, asked.task) == (event.number, event.task)
    return "" if is_open else f"question {event.number} was not open"


def _is_a_choice(event: events.Answered, state: RunState) -> str:
    asked = state.question
    fits = asked is not None and asked.number == event.number and event.choice in asked.choices
    return "" if fits else f"question {event.number} was not open, or has no such answer"


def _is_next(fits: Callable[[E, Any], bool]) -> Callable[[E, RunState], str]:
    """Return what compares an event with the step that came next; `fits`: it asks for the event."""

    def differs(event: E, state: RunState) -> str:
        step = next_step(state)
        return "" if fits(event, step) else f"next was {step}"

    return differs


def _is_to_be_inspected(event: events.Settled, state: RunState) -> str:
    # An inspection during which a client paused the run is kept.
    step = next_step(replace(state, paused=False))
    return "" if step == Settle(event.task) else f"next was {step}"


TABLE: Mapping[type, Meaning] = dict(
    (
        _row(
            events.RunBegun,
            transitions.run_begun,
            lambda e, _: of_run(f"begun: {begun_words(e)}"),
            _is_first,
        ),
        _row(
            events.PanelLoaded,
            lambda _, state: replace(state, keep_panel=True),
            lambda e, _: of_run(f"panel of {e.serial or 'the order'} loaded"),
        ),
        _row(
            events.Planned,
            lambda e, state: replace(state, waiting=e.tasks, to_plan=""),
            lambda e, _: of_decision("", f"planned: {' '.join(e.tasks)}", e.because),
            _is_next(lambda _, step: isinstance(step, Plan)),
        ),
        _row(
            events.PartRequested,
            transitions.part_requested,
            lambda e, _: of_task(e.task, "a new piece is presented"),
            _is_next(lambda e, step: step == Execute(e.task, Part.WHOLE)),
        ),
        _row(
            events.FeedRefused,
            transitions.feed_refused,
            lambda e, _: of_task(
                e.task, f"no piece was presented: error {e.code}: {e.text}", e.code
            ),
            _is_requested,
        ),
        _row(
            events.TaskBegun,
            transitions.task_begun,
            entries.task_begun,
            _is_next(lambda e, step: step == Execute(e.task, e.part)),
            Attempts.begin,
        ),
        _row(
            events.OperationEnded,
            transitions.operation_ended,
            lambda *_: (),  # it comes when its behavior has ended, beside the pictures
            _is_under_way,
            Attempts.operate,
        ),
        _row(events.StopReported, transitions.stop_reported, entries.stop_reported),
        _row(
            events.TaskEnded,
            transitions.task_ended,
            entries.task_ended,
            _is_under_way,
            Attempts.end,
        ),
        _row(
            events.Interrupted,
            transitions.interrupted,
            entries.interrupted,
            counts=Attempts.interrupt,
        ),
        _row(
            events.Settled,
            transitions.settled,
            entries.settled,
            _is_to_be_inspected,
            Attempts.settle,
        ),
        _row(
            events.Decided,
            transitions.decided,
            entries.decided,
            _is_next(lambda e, step: step == Decide(e.task)),
            Attempts.decide,
        ),
        _row(
            events.Asked,
            lambda e, state: replace(state, question=e, questions=e.number),
            lambda e, _: of_operator(
                e.task, f"asked: {e.text} ({', '.join(each.value for each in e.choices)})"
            ),
            _is_next(lambda e, step: step == Ask(e.task)),
        ),
        _row(
            events.Answered,
            transitions.answered,
            lambda e, _: of_operator("", f"answered: {e.choice.value}", e.by),
            _is_a_choice,
        ),
        _row(
            events.Escalated,
            transitions.escalated,
            lambda e, _: of_operator(e.task, f"not answered in time: {e.do.value}"),
            _is_open,
        ),
        _row(
            events.Commanded,
            transitions.commanded,
            lambda e, _: of_operator(e.task, e.command.value, e.by),
        ),
        _row(events.TaskElsewhere, transitions.task_elsewhere, entries.task_elsewhere),
        _row(
            events.TaskReturned,
            transitions.task_returned,
            lambda e, _: of_task(
                e.task, f"taken over from cell {e.cell}, which began it and went silent"
            ),
        ),
        _row(
            events.Blocked,
            lambda e, state: replace(state, stop=e.because),
            lambda e, _: of_run(f"cannot go on: {e.because}"),
        ),
        _row(
            events.RunEnded,
            lambda e, state: replace(state, ended=e),
            lambda e, _: of_run(f"ended {e.ending.value}", e.because),
            _is_next(lambda e, step: isinstance(step, EndRun) and step.ending is e.ending),
        ),
    )
)


def apply_event(event: Event, state: RunState) -> RunState:
    """Return the state after an event."""
    return replace(TABLE[type(event)].change(event, state), events=state.events + 1)


def state_after(events: Iterable[Event], state: RunState | None = None) -> RunState:
    """Return what is known after some events."""
    state = state or RunState()
    for event in events:
        state = apply_event(event, state)
    return state


def count_event(event: Event, attempts: Attempts) -> None:
    """Take in the next event of a run as what it counts for."""
    counts = TABLE[type(event)].counts
    if counts is not None:
        counts(attempts, event)


def attempts_of(events: Iterable[Event]) -> tuple[Attempt, ...]:
    """Return the behaviors of a run that have ended, in order."""
    attempts = Attempts()
    for event in events:
        count_event(event, attempts)
    return attempts.ended


def entries_of(events: Iterable[Event]) -> list[Entry]:
    """Return the record of a run; a picture's entry has its file's name in `because`.

    What a behavior did comes when it has ended, in the order of time, so that entries are only
    added.
    """
    found: list[Entry] = []
    attempts, now_s = Attempts(), 0.0
    for event in events:
        now_s = getattr(event, "at_s", 0.0) or now_s
        for entry in TABLE[type(event)].reads(event, attempts):
            found.append(replace(entry, position=len(found) + 1, time_s=entry.time_s or now_s))
        count_event(event, attempts)
    return found


def difference(event: Event, state: RunState) -> str:
    """Return how an event differs from what the state before it asked for; empty if it fits."""
    differs = TABLE[type(event)].differs
    return "" if differs is None else differs(event, state)
