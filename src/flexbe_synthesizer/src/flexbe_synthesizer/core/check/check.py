"""Prove a chart, or say everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.model import Chart, State
from flexbe_synthesizer.core.chart.names import is_topic_parameter
from flexbe_synthesizer.core.chart.problem import Problem, ProblemList
from flexbe_synthesizer.core.check.check_connections import (
    check_connections,
    check_defaults,
    check_parameters,
)
from flexbe_synthesizer.core.check.check_data_flow import check_data_flow, check_homes
from flexbe_synthesizer.core.check.check_names import (
    check_extensions,
    check_names,
    check_node_names,
    check_paths,
    check_priorities,
    check_use,
)
from flexbe_synthesizer.core.check.check_transitions import (
    check_conditions,
    check_events,
    check_loops,
    check_reachability,
    check_transitions,
)
from flexbe_synthesizer.core.library.resolve import (
    ResolvedChart,
    ResolvedNode,
    named_behaviors,
    resolve_chart,
    scopes,
)
from flexbe_synthesizer.core.library.signature import BehaviorClass, Effect, Library
from flexbe_synthesizer.core.machine.lift import lift
from flexbe_synthesizer.core.machine.machine_reader import InexpressibleError, read_machine


@dataclass(frozen=True)
class CheckedChart:
    """A chart with all that was found out about it; to be used only without errors."""

    resolved: ResolvedChart
    problems: tuple[Problem, ...]
    nested: NestedBehaviors


def check_chart(
    chart: Chart,
    library: Library,
    charts: Mapping[str, BehaviorClass],
    nested: NestedBehaviors | None = None,
    expect_time: Callable[[], None] = lambda: None,
) -> CheckedChart:
    """Return the chart with its names looked up, its data bound, and all its problems.

    Args:
        chart: what to check.
        library: what is on the ROS package path.
        charts: the behaviors that other charts become, by path.
        nested: what is known already of the behaviors in charts that are checked together.
        expect_time: called again and again; what it raises ends the check.
    """
    nested = nested or NestedBehaviors(library, charts)
    resolved, unresolved = resolve_chart(chart, library, charts, nested.effects)
    problems = ProblemList(expect_time)
    problems.take_all(unresolved)
    problems.take_all(check_paths(resolved))
    for scope in scopes(resolved):
        for check in _checks(scope, expect_time):
            expect_time()
            problems.take_all(check)
    return CheckedChart(resolved, tuple(problems), nested)


def _checks(scope: ResolvedChart, expect_time: Callable[[], None]) -> Iterator[Iterable[Problem]]:
    """Yield the checks of a chart or container, without what is inside containers in it."""
    if not scope.nodes:
        return  # reported as a missing element
    flow, graph = scope.flow, scope.graph
    yield check_names(scope)
    yield _check_nodes(scope, expect_time)
    yield check_defaults(scope)
    yield check_priorities(scope)
    yield check_transitions(scope)
    yield check_conditions(scope)
    yield check_reachability(scope, graph)
    yield check_loops(scope, graph)
    yield check_connections(scope, flow)
    yield check_data_flow(scope)
    yield check_homes(scope, flow)
    yield check_use(scope, flow)


def _check_nodes(scope: ResolvedChart, expect_time: Callable[[], None]) -> Iterator[Problem]:
    """Yield the problems of each node by itself; of equal nodes without any, check one."""
    faultless: set[object] = set()
    for entry in scope.nodes:
        expect_time()
        likeness = None if scope.is_concurrent else _likeness(entry)
        if likeness in faultless:
            continue
        problems = [
            *check_node_names(entry.node),
            *check_parameters(entry),
            *check_extensions(entry, scope),
        ]
        if not scope.is_concurrent:
            problems += check_events(entry)
        if likeness is not None and not problems:
            faultless.add(likeness)
        yield from problems


def _likeness(entry: ResolvedNode) -> object:
    """Return what is equal for nodes that have the same faults; None for one of its own kind."""
    node, use = entry.node, entry.use
    if not isinstance(node, State) or node.inputs or node.outputs or node.on_error:
        return None
    if not use.is_like_others:
        return None
    events = tuple([transition.event for transition in node.transitions])
    given = tuple(
        [
            (param.name, param.text if is_topic_parameter(param.name) else type(param.value))
            for param in node.params
        ]
    )
    return use, node.topic, events, given


# What the outcomes of behaviors inside a chart write: found in their own charts.
#
# A behavior whose chart is not at hand is read back from its file. Where that is not possible, for
# code of its own in it, nothing is certain: each of its outputs may be written or not.


class NestedBehaviors:
    """What the behaviors inside charts are made of and what they write, each found once.

    Attributes:
        read_back: the charts of behaviors that have none at hand, by module; None where the file
            holds more than a chart can say. They hold for as long as the library does.
    """

    def __init__(self, library: Library, charts: Mapping[str, BehaviorClass]) -> None:
        self._library = library
        self._charts = charts
        self.read_back: dict[str, Chart | None] = {}
        self._known: dict[str, tuple[Effect, ...]] = {}
        self._open: set[str] = set()
        self._resolved: dict[str, ResolvedChart] = {}

    def effects(self, behavior: BehaviorClass) -> tuple[Effect, ...]:
        """Return the effects of a behavior; none, which is all, while it contains itself."""
        if behavior.module in self._open:
            return self._known.get(behavior.module, ())
        trail = [behavior]
        while trail:
            one = trail[-1]
            self._open.add(one.module)
            inside = (b for b in self._inside(one) if b.module not in self._open)
            inner = next(inside, None)
            if inner is not None:
                trail.append(inner)
                continue
            self._known[one.module] = self._found(one)
            trail.pop()
        return self._known[behavior.module]

    def _inside(self, behavior: BehaviorClass) -> Iterator[BehaviorClass]:
        """Yield the behaviors inside another one, as far as their effects matter to it."""
        chart = self._chart(behavior) if behavior.outputs else None
        if chart is not None:
            yield from named_behaviors(chart, self._library, self._charts)

    def _chart(self, behavior: BehaviorClass) -> Chart | None:
        """Return the chart of a behavior, None if it cannot be read back."""
        if behavior.chart is not None:
            return behavior.chart
        if behavior.module not in self.read_back:
            self.read_back[behavior.module] = _read_back(behavior, self._library)
        return self.read_back[behavior.module]

    def _found(self, behavior: BehaviorClass) -> tuple[Effect, ...]:
        if not behavior.outputs:
            return ()
        resolved = self.resolved(behavior)
        if resolved is not None:
            return resolved.effects
        outputs = frozenset(port.name for port in behavior.outputs)
        return tuple(Effect(outcome, frozenset(), outputs) for outcome in behavior.outcomes)

    def resolved(self, behavior: BehaviorClass) -> ResolvedChart | None:
        """Return what a behavior is made of, None if its file cannot be read back."""
        chart = self._chart(behavior)
        if chart is not None and behavior.module not in self._resolved:
            found, _problems = resolve_chart(chart, self._library, self._charts, self.effects)
            self._resolved[behavior.module] = found
        return self._resolved.get(behavior.module)


def _read_back(behavior: BehaviorClass, library: Library) -> Chart | None:
    """Return what a behavior's file says about states and values, None if that cannot be read."""
    text, file = library.text_of(behavior), behavior.module
    try:
        return lift(read_machine(text, file, library, is_outline=True), file, is_outline=True)
    except InexpressibleError:
        return None
