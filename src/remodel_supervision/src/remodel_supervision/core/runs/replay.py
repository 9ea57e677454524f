"""Play a recorded run back: each event must be what the state before it asked for.

Of each behavior that ended by itself, the chart is followed by what its operations' states ended
with; it must lead to the same outcome, over the states that the engine said it entered.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.error_routes import FAILED_EVENT, codes_of_routes, route_event
from flexbe_synthesizer.core.chart.model import Behavior, Chart, Container
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.attempts import INTERRUPTED, Attempt
from remodel_supervision.core.runs.event_table import apply_event, difference
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.state import PERSON_FIRST, PREEMPTED, SERVER_GONE, RunState


@dataclass(frozen=True)
class Trace:
    """A run through one chart.

    Attributes:
        chart: that was run.
        path: of its container in the behavior; empty for the behavior itself.
        steps: (state id, event) in the order taken.
        outcome: in which it ended; None if it was stopped, or the records end before.
        children: traces of nested behaviors, in the order taken.
    """

    chart: Chart
    path: str
    steps: tuple[tuple[str, str], ...]
    outcome: str | None
    children: tuple[Trace, ...]


def trace(
    chart: Chart,
    operations: tuple[Operation, ...],
    charts: Mapping[str, Chart],
    error_names: Mapping[str, tuple[int, ...]],
) -> Trace:
    """Return the run that the operations of a behavior made through its chart.

    Args:
        chart: of the behavior.
        operations: of all its ability states, in order.
        charts: of the behaviors nested in it, by type.
        error_names: error codes by the names that `ext:on_error` uses.
    """
    return _follow(chart, "", iter(operations), charts, error_names=error_names)


def _follow(
    chart: Chart,
    path: str,
    operations: Iterator[Operation],
    charts: Mapping[str, Chart],
    error_names: Mapping[str, tuple[int, ...]],
) -> Trace:
    nodes = {node.id: node for node in chart.nodes}
    visits: Counter[str] = Counter()
    steps: list[tuple[str, str]] = []
    children: list[Trace] = []
    current = chart.initial
    while current in nodes:
        node = nodes[current]
        visits[current] += 1
        event: str | None
        operation = None
        if node.attempts is not None and visits[current] > node.attempts:
            event = "exhausted"
        elif isinstance(node, Behavior | Container):
            inner = node.body if isinstance(node, Container) else charts[node.type]
            child = _follow(inner, f"{path}/{node.id}", operations, charts, error_names=error_names)
            children.append(child)
            event = child.outcome
        else:
            operation = next(operations, None)
            ran = operation is not None and operation.state_path == f"{path}/{node.id}"
            event = operation.outcome if operation is not None and ran else None
        targets = {transition.event: transition.target for transition in node.transitions}
        if event == FAILED_EVENT and operation is not None:
            routed = codes_of_routes(node.on_error, error_names)
            for route, codes in zip(node.on_error, routed, strict=True):
                if operation.error_code in codes:
                    event = route_event(route)
                    targets[event] = route.target
        if not event or event not in targets:
            return Trace(chart, path, tuple(steps), None, children=tuple(children))
        steps.append((current, event))
        current = targets[event]
    return Trace(chart, path, tuple(steps), current, children=tuple(children))


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
