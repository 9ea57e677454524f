"""Check that connections name what exists, and that every input and output is fed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.data_flow import DataFlow, Key, Wiring, ports
from flexbe_synthesizer.core.model import Connection, Input, Output
from flexbe_synthesizer.core.problem import Code, Position, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, ResolvedNode, label
from flexbe_synthesizer.core.signature import Port, fits


def check_connections(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the problems with the connections, and with what they leave unfed."""
    for connection in resolved.chart.connections:
        yield from _check_ends(connection, resolved)
    yield from _check_duplicates(resolved)
    wiring = Wiring(resolved)
    yield from _check_inputs(resolved, flow, wiring)
    yield from _check_outputs(resolved, flow, wiring)


def _check_ends(connection: Connection, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the two ends of a connection."""
    chart = resolved.chart
    giver, taker = connection.output_state_id, connection.input_state_id
    if giver == taker == chart.name and connection.output and connection.output != connection.input:
        message = (
            f"FlexBE cannot copy input '{connection.output}' of {resolved.title} to its output "
        )
        message += f"'{connection.input}'; give both one name, or put a state between that copies."
        yield Problem(connection.position("input"), Code.UNKNOWN_INPUT, message)
        return
    if giver == chart.name:
        known = [port.name for port in chart.inputs]
        yield from _check_end(connection, "output", f"{resolved.title} has no input", known)
    else:
        yield from _check_state(giver, "output_state_id", connection, resolved)
        if (entry := resolved.by_id.get(giver)) is not None and entry.signature is not None:
            known = [port.name for port in ports(entry)[1]]
            yield from _check_end(connection, "output", f"'{giver}' has no output", known)
    if taker == chart.name:
        known = [port.name for port in chart.outputs]
        yield from _check_end(connection, "input", f"{resolved.title} has no output", known)
    else:
        yield from _check_state(taker, "input_state_id", connection, resolved)
        if (entry := resolved.by_id.get(taker)) is not None and entry.signature is not None:
            known = [port.name for port in ports(entry)[0]]
            yield from _check_end(connection, "input", f"'{taker}' has no input", known)


def _check_end(
    connection: Connection, attribute: str, lack: str, known: Sequence[str]
) -> Iterator[Problem]:
    """Yield a problem if the input or output that a connection names is not known."""
    name = connection.output if attribute == "output" else connection.input
    if name and name not in known:
        code = Code.UNKNOWN_OUTPUT if attribute == "output" else Code.UNKNOWN_INPUT
        message = f"{lack} '{name}'; {names.allowed(name, known)}"
        yield Problem(connection.position(attribute), code, message)


def _check_state(
    name: str, attribute: str, connection: Connection, resolved: ResolvedChart
) -> Iterator[Problem]:
    if name and name not in resolved.by_id:
        hint = names.allowed(name, [*resolved.by_id, resolved.chart.name])
        message = f"'{name}' is neither a state, a behavior nor {resolved.title}; {hint}"
        yield Problem(connection.position(attribute), Code.UNKNOWN_STATE, message)


def _check_duplicates(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each input fed twice, and each output with two homes."""
    fed: dict[Key, int] = {}
    homes: dict[Key, tuple[str, int]] = {}
    for connection in resolved.chart.connections:
        line = connection.position().line
        target = Key(connection.input_state_id, connection.input)
        if target.node and target.name and target.node != resolved.chart.name:
            if target in fed:
                message = f"input '{target.name}' of '{target.node}' is fed in line {fed[target]} "
                message += "already; a value has one home. Delete one connection."
                yield Problem(connection.position(), Code.DUPLICATE_CONNECTION, message)
            fed.setdefault(target, line)
        elif target.name:
            source = Key(connection.output_state_id, connection.output)
            other, other_line = homes.setdefault(source, (target.name, line))
            if other != target.name:
                message = (
                    f"output '{source.name}' of '{source.node}' feeds the output '{other}' of "
                )
                message += (
                    f"{resolved.title} in line {other_line} already, and a value has one home; "
                )
                message += "delete one connection."
                yield Problem(connection.position(), Code.CONFLICTING_OUTPUT, message)


def _check_inputs(resolved: ResolvedChart, flow: DataFlow, wiring: Wiring) -> Iterator[Problem]:
    """Yield a problem for each input of a state that nothing feeds, or a value of another type."""
    outputs = {Key(i, p.name): p for i, entry in resolved.by_id.items() for p in ports(entry)[1]}
    machine_inputs = {port.name: port for port in resolved.chart.inputs}
    for name, entry in resolved.by_id.items():
        for port in ports(entry)[0]:
            key = Key(name, port.name)
            connection = wiring.into_state.get(key)
            if connection is None and key not in flow.inputs:
                if key not in flow.defaulted:
                    yield _unbound(entry, port, outputs)
                continue
            given: Input | Port | None
            if connection is None or connection.output_state_id == resolved.chart.name:
                given = machine_inputs.get(connection.output if connection else port.name)
                source = f"input '{given.name}' of {resolved.title}" if given else ""
            else:
                producer = Key(connection.output_state_id, connection.output)
                given = outputs.get(producer)
                source = f"output '{producer.name}' of '{producer.node}'"
            place = _place(connection, entry, port)
            yield from _check_flow(source, given, f"input '{port.name}' of '{name}'", port, place)


def _place(connection: Connection | None, entry: ResolvedNode, port: Port) -> Position:
    """Return where a flow into a state is said: in a connection, an <input>, or not at all."""
    if connection is not None:
        return connection.position()
    declared = next((i for i in entry.node.inputs if i.name == port.name), None)
    return entry.node.position() if declared is None else declared.position()


def _unbound(entry: ResolvedNode, port: Port, outputs: Mapping[Key, Port]) -> Problem:
    """Return the problem of an input that nothing feeds, with the connections that would."""
    message = f"nothing feeds input '{port.name}' of {label(entry.node)}; "
    fitting = [key for key, other in outputs.items() if fits(other.type, port.type)]
    named = [key for key in fitting if key.name == port.name and key.node != entry.node.id]
    if named:
        source = named[0]
        message += f'add <connection output_state_id="{source.node}" output="{source.name}" '
        message += f'input_state_id="{entry.node.id}" input="{port.name}"/>, or '
    message += f'add <input name="{port.name}"/> to the <datamodel>'
    message += "." if named else ", or a <connection> from an output of another state."
    return Problem(_place(None, entry, port), Code.UNBOUND_INPUT, message)


def _check_flow(
    source: str,
    given: Input | Output | Port | None,
    target: str,
    wanted: Input | Output | Port,
    position: Position,
) -> Iterator[Problem]:
    """Yield a problem if the two ends of a flow have different types."""
    if given is not None and not fits(given.type or None, wanted.type or None):
        message = f"{source} is {given.type}, {target} is {wanted.type}; connect equal types."
        yield Problem(position, Code.TYPE_CONFLICT, message)


def _check_outputs(resolved: ResolvedChart, flow: DataFlow, wiring: Wiring) -> Iterator[Problem]:
    """Yield a problem for each machine output that nothing feeds, or with another type."""
    by_home: dict[str, list[Key]] = {}
    for key, home in flow.outputs.items():
        by_home.setdefault(home, []).append(key)
    is_known = all(entry.signature is not None for entry in resolved.nodes)
    for output in resolved.chart.outputs:
        is_fed = output.name in wiring.connected_outputs or output.name in by_home
        if is_known and output.name and not is_fed:
            message = (
                f"nothing feeds output '{output.name}' of {resolved.title}; no state has an output "
            )
            message += 'of that name. Add <connection output_state_id="..." output="..." '
            message += f'input_state_id="{resolved.chart.name}" input="{output.name}"/>.'
            yield Problem(output.position(), Code.UNFED_OUTPUT, message)
        yield from _check_feeds(output, by_home.get(output.name, ()), resolved, wiring)
    yield from _check_pass_through(resolved, wiring)
    for key, connection in wiring.into_machine.items():
        if key in flow.outputs and flow.outputs[key] != connection.input:
            message = f"'{key.name}' of '{key.node}' is read and written in one place, "
            message += f"'{flow.outputs[key]}', and cannot feed output '{connection.input}' too; "
            message += "put a state between that copies it."
            yield Problem(connection.position(), Code.CONFLICTING_OUTPUT, message)


def _check_feeds(
    output: Output, feeding: Sequence[Key], resolved: ResolvedChart, wiring: Wiring
) -> Iterator[Problem]:
    """Yield a problem for the first state that feeds a machine output with another type."""
    for key in feeding:
        port = next(p for p in ports(resolved.by_id[key.node])[1] if p.name == key.name)
        connection = wiring.into_machine.get(key)
        position = output.position() if connection is None else connection.position()
        source = f"output '{key.name}' of '{key.node}'"
        target = f"output '{output.name}' of {resolved.title}"
        problems = tuple(_check_flow(source, port, target, output, position))
        yield from problems
        if problems:
            return


def _check_pass_through(resolved: ResolvedChart, wiring: Wiring) -> Iterator[Problem]:
    """Yield a problem if an input and an output of one name have different types."""
    inputs = {port.name: port for port in resolved.chart.inputs}
    for output in resolved.chart.outputs:
        given = inputs.get(output.name)
        source = f"input '{output.name}' of {resolved.title}"
        target = "its output of the same name, which is the same value,"
        yield from _check_flow(source, given, target, output, output.position())
