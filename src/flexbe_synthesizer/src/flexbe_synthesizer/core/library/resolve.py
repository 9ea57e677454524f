"""A chart with all that its states and behaviors name: their classes, and so what they offer."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.literal import Literal, as_declared
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    ContainerKind,
    Node,
    State,
)
from flexbe_synthesizer.core.chart.names import ERROR_CODE
from flexbe_synthesizer.core.chart.quick import quick
from flexbe_synthesizer.core.library.data_flow import DataFlow, bind_data
from flexbe_synthesizer.core.library.definite_assignment import Values
from flexbe_synthesizer.core.library.graph import Graph, chart_graph
from flexbe_synthesizer.core.library.signature import (
    BehaviorClass,
    Parameter,
    Port,
    Signature,
    StateClass,
)


class Support(Enum):
    """The state classes that extensions are lowered to: package, class, extension."""

    COUNTER = ("remodel_states", "CountAttemptsState", "attempts")
    TIMER = ("flexbe_states", "WaitState", "timeout_s")
    CHOOSER = ("flexbe_states", "DecisionState", "on_error")

    __hash__ = object.__hash__  # that of Enum is a function in Python

    def __init__(self, package: str, class_name: str, extension: str) -> None:
        """Name the parts of the value."""
        self.package = package
        self.class_name = class_name
        self.extension = extension


@dataclass(frozen=True, eq=False)
class Use:
    """What a node names, and what that offers it; nodes that are used alike share one.

    Attributes:
        declaration: class of the state or behavior; None of a container, or if it was not found.
        signature: what it offers; None if the declaration was not found.
        is_qualified: the chart names the package of the state class.
        is_timed: its timeout is kept by a timer beside it, not by its own class.
        added_events: the events that extensions add, even if the class has them already.
        inputs: by name, with the types that the chart declares for them.
        outputs: by name, with the types that the chart declares for them.
    """

    declaration: StateClass | BehaviorClass | None = None
    signature: Signature | None = None
    is_qualified: bool = False
    is_timed: bool = False
    added_events: tuple[str, ...] = ()
    inputs: Mapping[str, Port] = field(default_factory=dict)
    outputs: Mapping[str, Port] = field(default_factory=dict)

    @cached_property
    def events(self) -> tuple[str, ...] | None:
        """Return the events that need a transition, None if its outcomes are not known."""
        if self.signature is None or self.signature.outcomes is None:
            return None
        return tuple(dict.fromkeys((*self.signature.outcomes, *self.added_events)))

    @cached_property
    def is_like_others(self) -> bool:
        """Return whether what it offers is the same whatever values its parameters have."""
        return (
            isinstance(self.declaration, StateClass)
            and not self.declaration.depends_on_values
            and not self.taking_source
        )

    @cached_property
    def taking_source(self) -> frozenset[str]:
        """Return the parameters that take Python source."""
        offered = self.signature.parameters if self.signature else ()
        return frozenset(parameter.name for parameter in offered if parameter.takes_source)

    @cached_property
    def taking_text(self) -> frozenset[str]:
        """Return the parameters that are declared as strings."""
        offered = self.signature.parameters if self.signature else ()
        return frozenset(parameter.name for parameter in offered if parameter.type == "string")

    @cached_property
    def time_limit(self) -> Parameter | None:
        """Return the parameter that limits a visit [s] to a state, None if its class has none."""
        declaration = self.declaration
        if not isinstance(declaration, StateClass):
            return None
        timer = Support.TIMER
        is_timer = (declaration.package, declaration.name) == (timer.package, timer.class_name)
        wanted = "wait_time" if is_timer else "timeout_s"
        return next((p for p in declaration.parameters if p.name == wanted), None)

    @cached_property
    def coded_events(self) -> tuple[str, ...]:
        """Return the outcomes of its class that may write an error code."""
        if self.signature is None or ERROR_CODE not in self.outputs:
            return ()
        effects = {effect.outcome: effect.possible for effect in self.signature.effects}
        outcomes = self.signature.outcomes or ()
        return tuple(o for o in outcomes if o not in effects or ERROR_CODE in effects[o])

    def has_own(self, event: str) -> bool:
        """Return whether the event is an outcome of its class."""
        return self.signature is not None and event in (self.signature.outcomes or ())


@quick
@dataclass(frozen=True, eq=False, slots=True)
class ResolvedNode:
    """A node of a chart with what it names; `body` is the content of a container."""

    node: AnyNode
    use: Use
    body: ResolvedChart | None = None


@dataclass(frozen=True, eq=False)
class ResolvedChart:
    """A chart with all its names looked up.

    Attributes:
        runs: how it runs what is in it; the chart of a file is a sequence.
        error_names: error codes by the names of codes and of classes of codes.
        is_inner: it is the content of a container.
        is_repeated: it is the content of a container that can be entered several times in a run,
            so that the attempts of a state in it may be spent before it is entered.
        support: the state classes that the extensions it uses are lowered to.
        by_id: the nodes in document order, of two with one id the first.
    """

    chart: Chart
    nodes: tuple[ResolvedNode, ...]
    runs: ContainerKind = ContainerKind.SEQUENCE
    support: Mapping[Support, StateClass] = field(default_factory=dict)
    by_id: Mapping[str, ResolvedNode] = field(default_factory=dict)
    error_names: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    is_inner: bool = False
    is_repeated: bool = False

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
        return Values(self)

    @cached_property
    def ids(self) -> names.Vocabulary:
        """Return the ids of the nodes."""
        return names.Vocabulary(self.by_id)

    @cached_property
    def targets(self) -> names.Vocabulary:
        """Return what transitions can lead to."""
        outcomes = (outcome.name for outcome in self.chart.outcomes)
        return names.Vocabulary(dict.fromkeys((*self.by_id, *outcomes)))

    @cached_property
    def connectable(self) -> names.Vocabulary:
        """Return what connections can come from and lead to."""
        return names.Vocabulary((*self.by_id, self.chart.name))

    @property
    def title(self) -> str:
        """Return what messages call it: the chart itself, or a container in it."""
        return f"container '{self.chart.name}'" if self.is_inner else "the chart"

    @property
    def is_concurrent(self) -> bool:
        """Return whether all of its nodes run at the same time."""
        return self.runs is ContainerKind.CONCURRENCY


def scopes(resolved: ResolvedChart) -> Iterator[ResolvedChart]:
    """Yield the chart and the content of each container in it, outer ones first."""
    yield resolved
    for entry in resolved.nodes:
        if entry.body is not None:
            yield from scopes(entry.body)


def label(node: Node) -> str:
    """Return kind and id of a node for messages."""
    return f"{node.kind} '{node.id}'"


def arguments(node: AnyNode, is_timed: bool) -> dict[str, Literal]:
    """Return the values that a node gives to its class, by parameter name."""
    values = {param.name: param.value for param in node.params}
    if isinstance(node, State) and node.topic is not None:
        values["topic"] = node.topic
    if isinstance(node, State) and node.timeout_s is not None and not is_timed:
        values["timeout_s"] = node.timeout_s
    return values


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
