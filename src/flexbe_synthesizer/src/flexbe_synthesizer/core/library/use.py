"""What each state, behavior and container of a chart names, and what that offers it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.literal import Literal
from flexbe_synthesizer.core.chart.model import AnyNode, Chart, ContainerKind, Node, State
from flexbe_synthesizer.core.chart.names import ERROR_CODE
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


@dataclass(frozen=True, eq=False, slots=True)
class UsedNode:
    """A node of a chart with what it names."""

    node: AnyNode
    use: Use


@dataclass(frozen=True, eq=False)
class Scope:
    """A chart, or the content of a container, with what its nodes name.

    Attributes:
        by_id: the nodes in document order, of two with one id the first.
        runs: how it runs what is in it; the chart of a file is a sequence.
        is_repeated: it is the content of a container that can be entered several times in a run,
            so that the attempts of a state in it may be spent before it is entered.
    """

    chart: Chart
    by_id: Mapping[str, UsedNode]
    runs: ContainerKind = ContainerKind.SEQUENCE
    is_repeated: bool = False

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
    def is_concurrent(self) -> bool:
        """Return whether all of its nodes run at the same time."""
        return self.runs is ContainerKind.CONCURRENCY


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
