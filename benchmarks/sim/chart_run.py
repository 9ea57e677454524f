"""Run a chart whose states are abilities, without ROS: the chart decides what follows a failure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping

from flexbe_synthesizer.core.chart.error_routes import codes_of_routes
from flexbe_synthesizer.core.chart.model import Chart, State
from remodel_supervision.edge.known_behaviors import nested_charts
from remodel_tasks.edge.fault_file import read_error_names

EXHAUSTED, FAILED, REFUSED = "exhausted", "failed", "command_error"
# What a state returns: FAILED or REFUSED with the error code, else the empty event of success.
Perform = Callable[[State], tuple[str, int]]


class ChartRun:
    """One run of a chart; time limits are left to the abilities.

    Attributes:
        visits: how often each state was entered.
    """

    def __init__(self, chart: Chart, error_names: Mapping[str, tuple[int, ...]]) -> None:
        """Take the chart, and the error codes by the names that it uses."""
        self._chart = chart
        self._error_names = error_names
        self.visits: Counter[str] = Counter()

    def run(self, perform: Perform) -> str:
        """Return the outcome with which the chart ends."""
        nodes = {node.id: node for node in self._chart.nodes}
        current = self._chart.initial
        while current in nodes:
            node = nodes[current]
            if not isinstance(node, State):
                raise TypeError(f"{current} is no state")
            current = self._after(node, perform)
        return current

    def _after(self, node: State, perform: Perform) -> str:
        """Return where a visit to a state leads."""
        targets = {transition.event: transition.target for transition in node.transitions}
        if node.attempts is not None and self.visits[node.id] >= node.attempts:
            return targets[EXHAUSTED]
        self.visits[node.id] += 1
        event, code = perform(node)
        if not event:
            return next(t for e, t in targets.items() if e not in (EXHAUSTED, FAILED, REFUSED))
        if event == FAILED:
            routed = codes_of_routes(node.on_error, self._error_names)
            for route, codes in zip(node.on_error, routed, strict=True):
                if code in codes:
                    return route.target
        return targets[event]


def place_connector() -> ChartRun:
    """Return a run of Place Connector (Figure 3 of Deliverable 5.1) by the chart that ships."""
    return ChartRun(nested_charts()["Place Connector"], read_error_names())
