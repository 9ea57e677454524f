"""What each part of a chart names and offers, what feeds each input, and the home of each value.

A home is a key of the root container's userdata. A value is named by who writes it: a machine
input or output keeps its own name, the output `pose` of a state `Locate` that feeds no machine
output lives in `locate_pose`. A state input is bound to the connection that names it, else to the
machine input of the same name, else to a default of its own if it is a behavior's input. A machine
output is fed by the connections that name it, else by all outputs of the same name. A key that a
state both reads and writes has the home that it reads.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Connection,
    ContainerKind,
    Literal,
    Node,
    State,
)
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


@dataclass(frozen=True)
class DataFlow:
    """Where every value lives.

    Attributes:
        inputs: home of each input by node and name; without those that nothing feeds.
        outputs: home of each output by node and name.
        defaulted: inputs of behaviors that keep the behavior's own default, as (node, name).
        wiring: the connections that say so.
    """

    inputs: Mapping[str, Mapping[str, str]]
    outputs: Mapping[str, Mapping[str, str]]
    defaulted: frozenset[tuple[str, str]]
    wiring: Wiring

    @cached_property
    def read(self) -> frozenset[str]:
        """Return the homes that some input reads."""
        return frozenset().union(*(homes.values() for homes in self.inputs.values()))


class Wiring:
    """The connections of a chart by what they feed.

    The first of several counts. A misspelt input stands for the one that was meant, so that one
    mistake is not reported a second time as an input that nothing feeds.
    """

    def __init__(self, scope: Scope) -> None:
        chart_name = scope.chart.name
        self.into_state: dict[tuple[str, str], Connection] = {}
        self.into_machine: dict[tuple[str, str], Connection] = {}
        self.passed_through: set[str] = set()
        self.connected_outputs: set[str] = set()
        for connection in scope.chart.connections:
            taker, name = connection.input_state_id, connection.input
            if taker != chart_name:
                entry = scope.by_id.get(taker)
                if entry is not None and name not in entry.use.inputs:
                    name = names.misspelt(name, entry.use.inputs) or name
                self.into_state.setdefault((taker, name), connection)
                continue
            self.connected_outputs.add(name)
            if connection.output_state_id != chart_name:
                source = (connection.output_state_id, connection.output)
                self.into_machine.setdefault(source, connection)
            elif connection.output == name:
                self.passed_through.add(name)


def bind_data(scope: Scope) -> DataFlow:
    """Return where each value of the chart lives."""
    wiring = Wiring(scope)
    binding = _Binding(scope, wiring)
    inputs: dict[str, dict[str, str]] = {}
    defaulted: list[tuple[str, str]] = []
    for node, entry in scope.by_id.items():
        if entry.use.inputs:
            inputs[node] = homes = {}
            for name, port in entry.use.inputs.items():
                home = binding.input_home(node, name)
                if home is not None:
                    homes[name] = home
                elif port.optional:
                    defaulted.append((node, name))
    return DataFlow(inputs, binding.output_homes(), frozenset(defaulted), wiring)


class _Binding:
    """The search for homes; each is found once."""

    def __init__(self, scope: Scope, wiring: Wiring) -> None:
        self._chart_name = scope.chart.name
        self._by_id = scope.by_id
        self._into_state = wiring.into_state
        self._into_machine = wiring.into_machine
        self._machine_inputs = {port.name for port in scope.chart.inputs}
        machine_outputs = {port.name for port in scope.chart.outputs}
        self._fed_by_name = machine_outputs - wiring.connected_outputs
        self._taken = self._machine_inputs | machine_outputs
        self._homes: dict[str, dict[str, str]] = {
            node: {} for node, entry in scope.by_id.items() if entry.use.outputs
        }

    def output_homes(self) -> Mapping[str, Mapping[str, str]]:
        """Return the home of each output."""
        for node, homes in self._homes.items():
            use = self._by_id[node].use
            for name in use.outputs:
                if name in homes:
                    continue
                if name in use.inputs:
                    self._output_home(node, name)
                else:
                    self._own_home(node, name)
        return self._homes

    def input_home(self, node: str, name: str) -> str | None:
        """Return the home that an input reads, None if nothing feeds it."""
        source = self._source(node, name)
        return self._output_home(*source) if isinstance(source, tuple) else source

    def _source(self, node: str, name: str) -> str | tuple[str, str] | None:
        """Return what feeds an input: a home, the output of a state, or nothing."""
        connection = self._into_state.get((node, name))
        if connection is None:
            return name if name in self._machine_inputs else None
        giver, output = connection.output_state_id, connection.output
        if giver == self._chart_name:
            return output if output in self._machine_inputs else None
        entry = self._by_id.get(giver)
        return None if entry is None or output not in entry.use.outputs else (giver, output)

    def _output_home(self, node: str, name: str) -> str:
        """Return the home that an output writes, and give it to all keys on the way there.

        States that read and write each other's keys in a circle would otherwise never find one.
        """
        trail: dict[tuple[str, str], None] = {}
        home = self._homes[node].get(name)
        while home is None:
            if name not in self._by_id[node].use.inputs or (node, name) in trail:
                home = self._own_home(node, name)
                break
            trail[node, name] = None
            source = self._source(node, name)
            if not isinstance(source, tuple):
                home = source or self._new_home(node, name)
                break
            node, name = source
            home = self._homes[node].get(name)
        for key_node, key_name in trail:
            self._homes[key_node][key_name] = home
        return home

    def _own_home(self, node: str, name: str) -> str:
        """Return the home of an output that is not read in the same place."""
        connection = self._into_machine.get((node, name))
        if connection is not None:
            home = connection.input
        else:
            home = name if name in self._fed_by_name else self._new_home(node, name)
        self._homes[node][name] = home
        return home

    def _new_home(self, node: str, name: str) -> str:
        """Return a home that nothing else lives in."""
        wanted = f"{names.snake_case(node)}_{names.snake_case(name)}"
        home = wanted if wanted not in self._taken else names.take_unused(wanted, self._taken)
        self._taken.add(home)
        return home
