"""A chart with all that its states and behaviors name: their classes, and so what they offer."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from flexbe_synthesizer.core.chart.literal import Literal, as_declared
from flexbe_synthesizer.core.chart.model import Behavior, Chart, Node
from flexbe_synthesizer.core.chart.quick import quick
from flexbe_synthesizer.core.library.data_flow import DataFlow, bind_data
from flexbe_synthesizer.core.library.definite_assignment import Values, outcome_effects
from flexbe_synthesizer.core.library.graph import Graph, chart_graph
from flexbe_synthesizer.core.library.signature import Effect, StateClass
from flexbe_synthesizer.core.library.use import Scope, Support, UsedNode, arguments


@quick
@dataclass(frozen=True, eq=False, slots=True)
class ResolvedNode(UsedNode):
    """A node of a chart with what it names; `body` is the content of a container."""

    body: ResolvedChart | None = None


@dataclass(frozen=True, eq=False)
class ResolvedChart(Scope):
    """A chart with all its names looked up.

    Attributes:
        error_names: error codes by the names of codes and of classes of codes.
        is_inner: it is the content of a container.
        support: the state classes that the extensions it uses are lowered to.
    """

    by_id: Mapping[str, ResolvedNode]
    nodes: tuple[ResolvedNode, ...] = ()
    support: Mapping[Support, StateClass] = field(default_factory=dict)
    error_names: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    is_inner: bool = False

    @cached_property
    def flow(self) -> DataFlow:
        """Return where each value of the chart lives."""
        return bind_data(self)

    @cached_property
    def graph(self) -> Graph:
        """Return what leads where."""
        return chart_graph(self)

    @cached_property
    def values(self) -> Values:
        """Return who writes which value, and when it is written."""
        return Values(self, self.flow, self.graph)

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Return what each of its outcomes writes; nothing without outputs."""
        outputs = frozenset(port.name for port in self.chart.outputs if port.name)
        return outcome_effects(self, outputs, self.values) if outputs else ()

    @property
    def title(self) -> str:
        """Return what messages call it: the chart itself, or a container in it."""
        return f"container '{self.chart.name}'" if self.is_inner else "the chart"


def scopes(resolved: ResolvedChart) -> Iterator[ResolvedChart]:
    """Yield the chart and the content of each container in it, outer ones first."""
    yield resolved
    for entry in resolved.nodes:
        if entry.body is not None:
            yield from scopes(entry.body)


def given_values(entry: ResolvedNode) -> dict[str, Literal]:
    """Return the values that a node gives to its class; texts where these are declared strings."""
    values = arguments(entry.node, entry.use.is_timed)
    for param in entry.node.params:
        if param.name in entry.use.taking_text and param.spelled:
            values[param.name] = as_declared(param.spelled, "string")
    return values


def included_path(chart: Chart, node: Node) -> str | None:
    """Return the path of the chart that a behavior names, None if it names no chart."""
    if not isinstance(node, Behavior) or not node.type.endswith(".xml"):
        return None
    return posixpath.normpath(posixpath.join(posixpath.dirname(chart.file), node.type))
