"""Compile charts together: each is checked with the others in view, then made a behavior."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.problem import ChartError, Problem, ProblemKind, errors_in
from flexbe_synthesizer.core.check.check import CheckedChart, NestedBehaviors, check_chart
from flexbe_synthesizer.core.library.graph import Edge, shortest_path
from flexbe_synthesizer.core.library.resolve import ResolvedNode, scopes
from flexbe_synthesizer.core.library.signature import BehaviorClass, Library, chart_behavior
from flexbe_synthesizer.core.library.sources import Manifest
from flexbe_synthesizer.core.machine.lower import lower
from flexbe_synthesizer.core.machine.machine import BehaviorUse, Machine, walk

Check: TypeAlias = Callable[
    [Chart, Library, Mapping[str, BehaviorClass], NestedBehaviors], CheckedChart
]


@dataclass(frozen=True)
class Unit:
    """A chart and the ROS package that its behavior goes to."""

    chart: Chart
    package: str


def check_units(
    units: Sequence[Unit],
    library: Library,
    report: Callable[[str], None] = lambda _path: None,
    check: Check = check_chart,
) -> Mapping[str, CheckedChart]:
    """Return each chart checked, by path; a behavior may be named though it is only a chart yet.

    Args:
        units: the charts.
        library: what is on the ROS package path.
        report: called with the path of each chart before it is checked; what it raises ends the
            checking.
        check: returns what `check_chart` does.
    """
    behaviors = {unit.chart.file: chart_behavior(unit.chart, unit.package) for unit in units}
    whole = library.with_behaviors(behaviors.values())
    nested = NestedBehaviors(whole, behaviors)
    checked = {}
    for unit in units:
        report(unit.chart.file)
        checked[unit.chart.file] = check(unit.chart, whole, behaviors, nested)
    doubled = tuple(_find_doubles(units))
    known = {behavior.name: behavior.contains for behavior in whole.behaviors} | {
        one.resolved.chart.name: _contained(one) for one in checked.values()
    }
    leaving = {name: [Edge(name, "", one) for one in inner] for name, inner in known.items()}
    return {
        path: replace(
            one,
            problems=(
                *one.problems,
                *_find_cycles(one, leaving),
                *(problem for problem in doubled if problem.position.file == path),
            ),
        )
        for path, one in checked.items()
    }


def _contained(checked: CheckedChart) -> tuple[str, ...]:
    """Return the display names of the behaviors in a chart."""
    return tuple(behavior.name for _entry, behavior in _behaviors_in(checked))


def _behaviors_in(checked: CheckedChart) -> Iterator[tuple[ResolvedNode, BehaviorClass]]:
    """Yield the behaviors in a chart, those inside containers too."""
    for scope in scopes(checked.resolved):
        for entry in scope.nodes:
            if isinstance(entry.use.declaration, BehaviorClass):
                yield entry, entry.use.declaration


def _find_cycles(checked: CheckedChart, leaving: Mapping[str, Sequence[Edge]]) -> Iterator[Problem]:
    """Yield a problem for each behavior in a chart that contains the chart again.

    Args:
        checked: the chart.
        leaving: edges from each behavior to those that it contains, by display name.
    """
    chart = checked.resolved.chart
    for entry, behavior in _behaviors_in(checked):
        is_itself = behavior.name == chart.name
        path = () if is_itself else shortest_path(behavior.name, chart.name, leaving)
        if path is not None:
            trail = (chart.name, behavior.name, *(edge.target for edge in path))
            message = f"the chart would contain itself: {' > '.join(trail)}; "
            message += "a behavior cannot be built out of itself."
            yield Problem(entry.node.position("type"), ProblemKind.CHART_CYCLE, message)


def _find_doubles(units: Sequence[Unit]) -> Iterator[Problem]:
    """Yield a problem for each chart that would be written over another."""
    first: dict[tuple[str, str], Chart] = {}
    for unit in units:
        chart = unit.chart
        if not chart.name:
            continue
        other = first.setdefault((unit.package, names.behavior_file(chart.name)), chart)
        if other.file != chart.file:
            message = f"'{chart.name}' becomes the same file as '{other.name}' of {other.file}; "
            message += "rename one of them."
            yield Problem(chart.position("name"), ProblemKind.DUPLICATE_BEHAVIOR, message)


def compile_chart(checked: CheckedChart, package: str) -> Machine:
    """Return the behavior that a checked chart becomes.

    Raises:
        ChartError: if it has errors.
    """
    errors = errors_in(checked.problems)
    if errors:
        raise ChartError(errors)
    return lower(checked.resolved, package)


def manifest_of(machine: Machine) -> Manifest:
    """Return the manifest of a behavior."""
    contents = [child.content for _path, child in walk(machine.root)]
    contained = {c.behavior.name for c in contents if isinstance(c, BehaviorUse)}
    return Manifest(
        machine.name,
        machine.package,
        names.behavior_module(machine.name),
        names.behavior_class(machine.name),
        contains=tuple(sorted(contained)),
    )
