"""Prove a chart, or say everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.check_connections import check_connections
from flexbe_synthesizer.core.check_data_flow import check_data_flow
from flexbe_synthesizer.core.check_names import check_names
from flexbe_synthesizer.core.check_parameters import check_parameters
from flexbe_synthesizer.core.check_reachability import check_reachability
from flexbe_synthesizer.core.check_transitions import check_transitions
from flexbe_synthesizer.core.data_flow import DataFlow, bind_data
from flexbe_synthesizer.core.graph import chart_graph
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.model import Chart
from flexbe_synthesizer.core.problem import Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, resolve_chart
from flexbe_synthesizer.core.signature import BehaviorClass


@dataclass(frozen=True)
class CheckedChart:
    """A chart with all that was found out about it; to be used only without errors."""

    resolved: ResolvedChart
    flow: DataFlow
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
    flow = bind_data(resolved)
    graph = chart_graph(resolved)
    problems = (
        *unresolved,
        *check_names(resolved),
        *check_parameters(resolved),
        *check_transitions(resolved),
        *check_reachability(resolved, graph),
        *check_connections(resolved, flow),
        *check_data_flow(resolved, flow, graph),
    )
    return CheckedChart(resolved, flow, problems)
