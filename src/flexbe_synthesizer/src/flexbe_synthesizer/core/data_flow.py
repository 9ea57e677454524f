"""Bind each input of a chart to what feeds it, and give each value its home.

A home is a key of the root container's userdata. A value is named by who writes it: a machine
input or output keeps its own name, the output `pose` of a state `Locate` that feeds no machine
output lives in `locate_pose`. A state input is bound to the connection that names it, else to the
machine input of the same name, else to a default of its own if it is a behavior's input. A machine
output is fed by the connections that name it, else by all outputs of the same name. A key that a
state both reads and writes has the home that it reads.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.model import Connection
from flexbe_synthesizer.core.resolve import ResolvedChart, ResolvedNode
from flexbe_synthesizer.core.signature import Port


class Key(NamedTuple):
    """An input or output of a state or behavior in the chart."""

    node: str
    name: str


@dataclass(frozen=True)
class DataFlow:
    """Where every value lives.

    Attributes:
        inputs: home of each input; without those that nothing feeds.
        outputs: home of each output.
        defaulted: inputs of behaviors that keep the behavior's own default.
    """

    inputs: Mapping[Key, str]
    outputs: Mapping[Key, str]
    defaulted: frozenset[Key]


class Wiring:
    """The connections of a chart by what they feed.

    The first of several counts. A misspelt input stands for the one that was meant, so that one
    mistake is not reported a second time as an input that nothing feeds.
    """

    def __init__(self, resolved: ResolvedChart) -> None:
        """Sort the connections."""
        self._chart = resolved.chart
        self.into_state: dict[Key, Connection] = {}
        self.into_machine: dict[Key, Connection] = {}
        self.passed_through: set[str] = set()
        self.connected_outputs: set[str] = set()
        for connection in resolved.chart.connections:
            source = Key(connection.output_state_id, connection.output)
            if connection.input_state_id != self._chart.name:
                entry = resolved.by_id.get(connection.input_state_id)
                offered = [port.name for port in ports(entry)[0]] if entry else []
                name = connection.input
                meant = name if name in offered else names.misspelt(name, offered) or name
                target = Key(connection.input_state_id, meant)
                self.into_state.setdefault(target, connection)
                continue
            self.connected_outputs.add(connection.input)
            if connection.output_state_id != self._chart.name:
                self.into_machine.setdefault(source, connection)
            elif connection.output == connection.input:
                self.passed_through.add(connection.input)


def ports(entry: ResolvedNode) -> tuple[tuple[Port, ...], tuple[Port, ...]]:
    """Return inputs and outputs of a node, with the types that the chart declares for them."""
    return entry.inputs, entry.outputs


def bind_data(resolved: ResolvedChart) -> DataFlow:
    """Return where each value of the chart lives."""
    binding = _Binding(resolved, Wiring(resolved))
    inputs = {key: binding.input_home(key) for key in binding.input_ports}
    return DataFlow(
        inputs={key: home for key, home in inputs.items() if home is not None},
        outputs={key: binding.output_home(key) for key in binding.output_ports},
        defaulted=frozenset(
            key
            for key, port in binding.input_ports.items()
            if inputs[key] is None and port.optional
        ),
    )


class _Binding:
    """The search for homes; each is found once."""

    def __init__(self, resolved: ResolvedChart, wiring: Wiring) -> None:
        self._chart_name = resolved.chart.name
        self._wiring = wiring
        self._machine_inputs = {port.name for port in resolved.chart.inputs}
        entries = resolved.by_id.items()
        self.input_ports = {Key(i, p.name): p for i, entry in entries for p in ports(entry)[0]}
        self.output_ports = {Key(i, p.name): p for i, entry in entries for p in ports(entry)[1]}
        machine_outputs = {port.name for port in resolved.chart.outputs}
        self._fed_by_name = machine_outputs - wiring.connected_outputs
        self._taken = self._machine_inputs | machine_outputs
        self._homes: dict[Key, str] = {}

    def input_home(self, key: Key, trail: tuple[Key, ...] = ()) -> str | None:
        """Return the home that an input reads, None if nothing feeds it."""
        connection = self._wiring.into_state.get(key)
        if connection is None:
            return key.name if key.name in self._machine_inputs else None
        source = Key(connection.output_state_id, connection.output)
        if source.node == self._chart_name:
            return source.name if source.name in self._machine_inputs else None
        if source not in self.output_ports:
            return None
        return self.output_home(source, trail)

    def output_home(self, key: Key, trail: tuple[Key, ...] = ()) -> str:
        """Return the home that an output writes.

        `trail` holds the keys being looked for: states that read and write each other's keys in a
        circle would otherwise never find a home.
        """
        if key in self._homes:
            return self._homes[key]
        home = None
        if key in self.input_ports and key not in trail:
            home = self.input_home(key, (*trail, key))
        elif key in self._wiring.into_machine:
            home = self._wiring.into_machine[key].input
        elif key.name in self._fed_by_name:
            home = key.name
        if home is None:
            wanted = f"{names.snake_case(key.node)}_{names.snake_case(key.name)}"
            home = names.take_unused(wanted, self._taken)
            self._taken.add(home)
        return self._homes.setdefault(key, home)
