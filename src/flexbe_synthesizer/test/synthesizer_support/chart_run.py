"""Follow one run of a chart by the meaning of its language."""

from __future__ import annotations

from collections.abc import Callable

from flexbe_synthesizer.core.chart.model import AnyNode, Chart, Container

Chooser = Callable[[str, tuple[str, ...]], str]
Events = Callable[[AnyNode], tuple[str, ...]]


def run(
    chart: Chart, events_of: Events, choose: Chooser, most_steps: int
) -> tuple[str | None, tuple[tuple[str, str], ...]]:
    """Follow one run of a chart; containers with states side by side take them in their order.

    Args:
        chart: what to run.
        events_of: returns the events that a state or behavior ends with.
        choose: returns the event that a state ends with, from its path and its events.
        most_steps: where to stop.

    Returns:
        The outcome, None if the steps ran out; and (path, event) of each state that was visited.
    """
    runner = _Runner(events_of, choose, most_steps)
    return runner.outcome(chart, ""), tuple(runner.steps)


class _Runner:
    """Follows one run."""

    def __init__(self, events_of: Events, choose: Chooser, most_steps: int) -> None:
        self._events_of = events_of
        self._choose = choose
        self._most_steps = most_steps
        self._visits: dict[str, int] = {}
        self.steps: list[tuple[str, str]] = []

    def outcome(self, chart: Chart, path: str) -> str | None:
        if not chart.initial:
            events: dict[str, str] = {}
            for node in chart.nodes:
                event = self._event(node, f"{path}/{node.id}")
                if event is None:
                    return None
                events[node.id] = event
                for condition in chart.conditions:
                    if all(events.get(when.state) == when.event for when in condition.all_of):
                        return condition.outcome
            return None
        nodes, target = {node.id: node for node in chart.nodes}, chart.initial
        while target in nodes:
            event = self._event(nodes[target], f"{path}/{target}")
            if event is None:
                return None
            target = next(t.target for t in nodes[target].transitions if t.event == event)
        return target

    def _event(self, node: AnyNode, here: str) -> str | None:
        if len(self.steps) == self._most_steps:
            return None
        if node.attempts is not None:
            self._visits[here] = self._visits.get(here, 0) + 1
            if self._visits[here] > node.attempts:
                self.steps.append((here, "exhausted"))
                return "exhausted"
        if isinstance(node, Container):
            return self.outcome(node.body, here)
        event = self._choose(here, self._events_of(node))
        self.steps.append((here, event))
        return event
