"""Play a recorded run back: each event must be what the state before it asked for.

Of each behavior that ended by itself, the chart is followed by what its operations' states ended
with; it must lead to the same outcome, over the states that the engine said it entered.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.model import Chart
from remodel_supervision.core.runs.attempts import INTERRUPTED, Attempt
from remodel_supervision.core.runs.event_table import apply_event, difference
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.state import PERSON_FIRST, PREEMPTED, SERVER_GONE, RunState
from remodel_supervision.core.trace import trace


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
        differs = difference(event, state)
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
