"""Prove a chart, or say everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.check_conditions import check_conditions
from flexbe_synthesizer.core.check_connections import check_connections
from flexbe_synthesizer.core.check_data_flow import check_data_flow
from flexbe_synthesizer.core.check_extensions import check_extensions
from flexbe_synthesizer.core.check_loops import check_loops
from flexbe_synthesizer.core.check_names import check_names, check_paths
from flexbe_synthesizer.core.check_parameters import check_parameters
from flexbe_synthesizer.core.check_reachability import check_reachability
from flexbe_synthesizer.core.check_transitions import check_transitions
from flexbe_synthesizer.core.check_use import check_use
from flexbe_synthesizer.core.data_flow import bind_data
from flexbe_synthesizer.core.graph import chart_graph
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.model import Chart
from flexbe_synthesizer.core.problem import Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, resolve_chart, scopes
from flexbe_synthesizer.core.signature import BehaviorClass


@dataclass(frozen=True)
class CheckedChart:
    """A chart with all that was found out about it; to be used only without errors."""

    resolved: ResolvedChart
    problems: tuple[Problem, ...]


def check_chart(
    chart: Chart, library: Library, charts: Mapping[str, BehaviorClass]
) -> CheckedChart:
    """Return the chart with its names looked up, its data bound, and all its problems.

    Args:
        chart: what to check.
        library: what is on the ROS package path.
        charts: the behaviors that other charts become, by path.
    """
    resolved, unresolved = resolve_chart(chart, library, charts)
    problems = [*unresolved, *check_paths(resolved)]
    for scope in scopes(resolved):
        problems.extend(_check_scope(scope))
    return CheckedChart(resolved, tuple(problems))


def _check_scope(scope: ResolvedChart) -> Iterator[Problem]:
    """Yield what is wrong in a chart or container, without what is inside containers in it."""
    if not scope.nodes:
        return  # told as a missing element
    flow, graph = bind_data(scope), chart_graph(scope)
    yield from check_names(scope)
    yield from check_parameters(scope)
    yield from check_extensions(scope)
    yield from check_transitions(scope)
    yield from check_conditions(scope)
    yield from check_reachability(scope, graph)
    yield from check_loops(scope, graph)
    yield from check_connections(scope, flow)
    yield from check_data_flow(scope, flow, graph)
    yield from check_use(scope, flow)
