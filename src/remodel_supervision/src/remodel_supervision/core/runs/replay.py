"""Play a recorded run back: each event must be what the state before it asked for.

Of each behavior that ended by itself, the chart is followed by what its operations' states ended
with; it must lead to the same outcome, over the states that the engine said it entered.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import Chart
from remodel_supervision.core.runs.attempts import INTERRUPTED, Attempt
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    Blocked,
    Commanded,
    Decided,
    Escalated,
    Event,
    FeedRefused,
    Interrupted,
    OperationEnded,
    PanelLoaded,
    Part,
    PartRequested,
    Planned,
    RunBegun,
    RunEnded,
    Settled,
    StopReported,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_supervision.core.runs.fold import apply_event
from remodel_supervision.core.runs.state import (
    PERSON_FIRST,
    PREEMPTED,
    SERVER_GONE,
    RunState,
    Stage,
)
from remodel_supervision.core.runs.step import (
    Ask,
    Decide,
    EndRun,
    Execute,
    Plan,
    Settle,
    Step,
    next_step,
)
from remodel_supervision.core.trace import trace

# What may happen at any time, whatever comes next.
_ANY_TIME = (
    Interrupted,
    StopReported,
    Commanded,
    Blocked,
    TaskElsewhere,
    TaskReturned,
    PanelLoaded,
)


@dataclass(frozen=True)
class Frame:
    """An event in its place.

    Attributes:
        event: that happened.
        after: the state after it.
        differs: how it differs from what the state before it asked for; empty if it does not.
    """

    event: Event
    after: RunState
    differs: str


def replayed(events: Sequence[Event]) -> Iterator[Frame]:
    """Yield the events of a run with the states after them."""
    state = RunState()
    for event in events:
        differs = _difference(event, state)
        state = apply_event(event, state)
        yield Frame(event, state, differs)


def path_difference(
    attempt: Attempt,
    chart: Chart,
    nested: Mapping[str, Chart],
    error_names: Mapping[str, tuple[int, ...]],
) -> str:
    """Return how a behavior's record contradicts its chart; empty if it does not.

    Args:
        attempt: the behavior.
        chart: of the behavior.
        nested: charts of the behaviors in it, by type.
        error_names: error codes by the names that charts use.
    """
    execution = attempt.execution
    if execution.outcome in (INTERRUPTED, PREEMPTED):
        return ""
    operations = execution.operations
    asked = [operation.state_path for operation in operations]
    entered = [path for path in attempt.path if path in set(asked)]
    if operations and operations[-1].error_code in SERVER_GONE | PERSON_FIRST:
        # What would begin after it is refused, which leaves no record.
        return "" if entered[: len(asked)] == asked else _path_text(entered, asked)
    if attempt.path and entered != asked:
        return _path_text(entered, asked)
    outcome = trace(chart, operations, nested, error_names).outcome
    if outcome != execution.outcome:
        return f"the chart leads to {outcome}, the behavior ended {execution.outcome}"
    return ""


def _path_text(entered: list[str], asked: list[str]) -> str:
    return f"the engine entered {entered}, operations are of {asked}"


def _difference(event: Event, state: RunState) -> str:
    if isinstance(event, RunBegun):
        return "" if state == RunState() else "a run begins once"
    if isinstance(event, _ANY_TIME):
        return ""
    if isinstance(event, OperationEnded | TaskEnded):
        task = state.tasks.get(event.task)
        running = task is not None and task.stage is Stage.RUNNING
        return "" if running else f"{event.task} was not under way"
    if isinstance(event, FeedRefused):
        task = state.tasks.get(event.task)
        requested = task is not None and task.name == state.current and task.piece
        return "" if requested else f"no piece of {event.task} was asked for"
    if isinstance(event, Escalated):
        asked = state.question
        is_open = asked is not None and (asked.number, asked.task) == (event.number, event.task)
        return "" if is_open else f"question {event.number} was not open"
    if isinstance(event, Answered):
        asked = state.question
        fits = asked is not None and asked.number == event.number and event.choice in asked.choices
        return "" if fits else f"question {event.number} was not open, or has no such answer"
    # An inspection during which a client paused the run is kept.
    step = next_step(replace(state, paused=False) if isinstance(event, Settled) else state)
    return "" if _fits(event, step) else f"next was {step}"


def _fits(event: Event, step: Step | None) -> bool:
    match event, step:
        case Planned(), Plan():
            return True
        case PartRequested(), Execute():
            return (event.task, Part.WHOLE) == (step.task, step.part)
        case TaskBegun(), Execute():
            return (event.task, event.part) == (step.task, step.part)
        case Settled(), Settle():
            return event.task == step.task
        case Decided(), Decide():
            return event.task == step.task
        case Asked(), Ask():
            return event.task == step.task
        case RunEnded(), EndRun():
            return event.ending is step.ending
    return False
