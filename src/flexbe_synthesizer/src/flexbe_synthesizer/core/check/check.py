"""Prove a chart, or say everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.model import Chart, State
from flexbe_synthesizer.core.chart.names import is_topic_parameter
from flexbe_synthesizer.core.chart.problem import Problem, ProblemList
from flexbe_synthesizer.core.check.check_conditions import check_conditions
from flexbe_synthesizer.core.check.check_connections import check_connections
from flexbe_synthesizer.core.check.check_data_flow import check_data_flow
from flexbe_synthesizer.core.check.check_extensions import check_extensions, check_priorities
from flexbe_synthesizer.core.check.check_homes import check_homes
from flexbe_synthesizer.core.check.check_loops import check_loops
from flexbe_synthesizer.core.check.check_names import check_names, check_node_names, check_paths
from flexbe_synthesizer.core.check.check_parameters import check_defaults, check_parameters
from flexbe_synthesizer.core.check.check_reachability import check_reachability
from flexbe_synthesizer.core.check.check_transitions import check_events, check_transitions
from flexbe_synthesizer.core.check.check_use import check_use
from flexbe_synthesizer.core.check.nested import NestedBehaviors
from flexbe_synthesizer.core.library.library import Library
from flexbe_synthesizer.core.library.lookup import resolve_chart
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode, scopes
from flexbe_synthesizer.core.library.signature import BehaviorClass


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
