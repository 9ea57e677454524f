"""Follow a run through its chart: which states were taken, by which events.

The abilities' records say how each ability state ended; the chart says where that leads. Bounds on
attempts and the outcomes of nested behaviors follow from both, so they need no record.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.error_routes import FAILED_EVENT, codes_of_routes, route_event
from flexbe_synthesizer.core.chart.model import Behavior, Chart, Container
from remodel_supervision.core.run import Operation


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
