"""Check connections, parameters and declared inputs and outputs against what exists."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from functools import cached_property

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import (
    Behavior,
    Connection,
    Input,
    Literal,
    Node,
    Output,
    State,
    format_literal,
    type_of,
)
from flexbe_synthesizer.core.chart.problem import Position, Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import DataFlow, Wiring, arguments, label
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode, given_values
from flexbe_synthesizer.core.library.signature import (
    FromParameter,
    Port,
    Signature,
    StateClass,
    fits,
)
from flexbe_synthesizer.core.machine.machine import PARAMETER, PREDICATES


def check_connections(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the problems with the connections, and with what they leave unfed."""
    ends = _Ends(resolved)
    for connection in resolved.chart.connections:
        if not ends.exist(connection):
            yield from _check_ends(connection, resolved)
    yield from _check_duplicates(resolved)
    yield from _check_inputs(resolved, flow)
    yield from _check_outputs(resolved, flow)


class _Ends:
    """What a connection can come from, and what it can lead to."""

    def __init__(self, resolved: ResolvedChart) -> None:
        chart = resolved.chart
        self._givers: dict[str, Container[str]] = {
            name: entry.use.outputs for name, entry in resolved.by_id.items()
        }
        self._takers: dict[str, Container[str]] = {
            name: entry.use.inputs for name, entry in resolved.by_id.items()
        }
        self._givers[chart.name] = {port.name for port in chart.inputs}
        self._takers[chart.name] = {port.name for port in chart.outputs}
        self._chart_name = chart.name

    def exist(self, connection: Connection) -> bool:
        """Return whether both ends exist, and are not both in the chart's own data."""
        giver, taker = connection.output_state_id, connection.input_state_id
        return (
            connection.output in self._givers.get(giver, ())
            and connection.input in self._takers.get(taker, ())
            and not giver == taker == self._chart_name
        )


def _check_ends(connection: Connection, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the two ends of a connection."""
    chart = resolved.chart
    giver, taker = connection.output_state_id, connection.input_state_id
    if giver == taker == chart.name and connection.output and connection.output != connection.input:
        message = (
            f"FlexBE cannot copy input '{connection.output}' of {resolved.title} to its output "
        )
        message += f"'{connection.input}'; give both one name, or put a state between that copies."
        yield Problem(connection.position("input"), ProblemKind.UNKNOWN_INPUT, message)
        return
    for attribute, owner, ports, lack in (
        ("output", giver, chart.inputs, "input"),
        ("input", taker, chart.outputs, "output"),
    ):
        if owner == chart.name:
            known = [port.name for port in ports]
            yield from _check_end(connection, attribute, f"{resolved.title} has no {lack}", known)
            continue
        yield from _check_state(owner, f"{attribute}_state_id", connection, resolved)
        if (entry := resolved.by_id.get(owner)) is not None and entry.use.signature is not None:
            known = [*(entry.use.outputs if attribute == "output" else entry.use.inputs)]
            yield from _check_end(connection, attribute, f"'{owner}' has no {attribute}", known)


def _check_end(
    connection: Connection, attribute: str, lack: str, known: Sequence[str]
) -> Iterator[Problem]:
    """Yield a problem if the input or output that a connection names is not known."""
    name = connection.output if attribute == "output" else connection.input
    if name and name not in known:
        code = ProblemKind.UNKNOWN_OUTPUT if attribute == "output" else ProblemKind.UNKNOWN_INPUT
        message = f"{lack} '{name}'; {names.allowed(name, known)}"
        yield Problem(connection.position(attribute), code, message)


def _check_state(
    name: str, attribute: str, connection: Connection, resolved: ResolvedChart
) -> Iterator[Problem]:
    if name and name not in resolved.by_id:
        hint = names.allowed(name, resolved.connectable)
        message = f"'{name}' is neither a state, a behavior nor {resolved.title}; {hint}"
        yield Problem(connection.position(attribute), ProblemKind.UNKNOWN_STATE, message)


def _check_duplicates(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each input fed twice, and each output with two homes."""
    fed: dict[tuple[str, str], Connection] = {}
    homes: dict[tuple[str, str], Connection] = {}
    for connection in resolved.chart.connections:
        taker, name = connection.input_state_id, connection.input
        if taker and name and taker != resolved.chart.name:
            first = fed.setdefault((taker, name), connection)
            if first is not connection:
                message = f"input '{name}' of '{taker}' is fed in line {first.position().line} "
                message += "already; a value has one home. Delete one connection."
                yield Problem(connection.position(), ProblemKind.DUPLICATE_CONNECTION, message)
        elif name:
            source = (connection.output_state_id, connection.output)
            first = homes.setdefault(source, connection)
            if first.input != name:
                message = f"output '{source[1]}' of '{source[0]}' feeds the output "
                message += f"'{first.input}' of {resolved.title} in line {first.position().line} "
                message += "already, and a value has one home; delete one connection."
                yield Problem(connection.position(), ProblemKind.CONFLICTING_OUTPUT, message)


def _check_inputs(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each input of a state that nothing feeds, or a value of another type."""
    machine_inputs: dict[str, Input | Port] = {port.name: port for port in resolved.chart.inputs}
    givers = _Givers(resolved)
    for node, entry in resolved.by_id.items():
        for name, port in entry.use.inputs.items():
            connection = flow.wiring.into_state.get((node, name))
            if connection is None and name not in flow.inputs[node]:
                if (node, name) not in flow.defaulted:
                    yield _unbound(entry, port, givers)
                continue
            given: Input | Port | None
            if connection is None:
                given = machine_inputs.get(name)
            elif connection.output_state_id == resolved.chart.name:
                given = machine_inputs.get(connection.output)
            else:
                giver = resolved.by_id.get(connection.output_state_id)
                given = giver.use.outputs.get(connection.output) if giver else None
            if given is None or given.type == port.type or fits(given.type or None, port.type):
                continue
            if connection is None or connection.output_state_id == resolved.chart.name:
                source = f"input '{given.name}' of {resolved.title}"
            else:
                source = f"output '{given.name}' of '{connection.output_state_id}'"
            place = _place(connection, entry, port)
            yield from _check_flow(
                source, given, f"input '{name}' of '{node}'", port, position=place
            )


def _place(connection: Connection | None, entry: ResolvedNode, port: Port) -> Position:
    """Return where a flow into a state is said: in a connection, an <input>, or not at all."""
    if connection is not None:
        return connection.position()
    declared = next((i for i in entry.node.inputs if i.name == port.name), None)
    return entry.node.position() if declared is None else declared.position()


class _Givers:
    """The outputs that could feed an input of their name; of those with one type the first two."""

    def __init__(self, resolved: ResolvedChart) -> None:
        self._resolved = resolved

    @cached_property
    def _by_name(self) -> Mapping[str, list[tuple[str, str | None]]]:
        found: dict[str, list[tuple[str, str | None]]] = {}
        count: dict[tuple[str, str | None], int] = {}
        for node, entry in self._resolved.by_id.items():
            for name, port in entry.use.outputs.items():
                count[name, port.type] = count.get((name, port.type), 0) + 1
                if count[name, port.type] <= 2:
                    found.setdefault(name, []).append((node, port.type))
        return found

    def find(self, port: Port, taker: str) -> str | None:
        """Return the first other state with an output of the name, and of a type that fits."""
        known = self._by_name.get(port.name, ())
        return next((n for n, given in known if n != taker and fits(given, port.type)), None)


def _unbound(entry: ResolvedNode, port: Port, givers: _Givers) -> Problem:
    """Return the problem of an input that nothing feeds, with a connection that would."""
    message = f"nothing feeds input '{port.name}' of {label(entry.node)}; "
    source = givers.find(port, entry.node.id)
    if source is not None:
        message += f'add <connection output_state_id="{source}" output="{port.name}" '
        message += f'input_state_id="{entry.node.id}" input="{port.name}"/>, or '
    message += f'add <input name="{port.name}"/> to the <datamodel>'
    message += ", or a <connection> from an output of another state." if source is None else "."
    return Problem(_place(None, entry, port), ProblemKind.UNBOUND_INPUT, message)


def _check_flow(
    source: str,
    given: Input | Output | Port,
    target: str,
    wanted: Input | Output | Port,
    position: Position,
) -> Iterator[Problem]:
    """Yield a problem if the two ends of a flow have different types."""
    if not fits(given.type or None, wanted.type or None):
        message = f"{source} is {given.type}, {target} is {wanted.type}; connect equal types."
        yield Problem(position, ProblemKind.TYPE_CONFLICT, message)


def _check_outputs(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each machine output that nothing feeds, or with another type."""
    feeding: dict[str, list[tuple[str, str]]] = {port.name: [] for port in resolved.chart.outputs}
    named: set[str] = set()
    for node, homes in flow.outputs.items():
        named.update(homes)
        for name, home in homes.items():
            if home in feeding:
                feeding[home].append((node, name))
    wiring = flow.wiring
    is_known = all(entry.use.signature is not None for entry in resolved.nodes)
    for output in resolved.chart.outputs:
        is_fed = output.name in wiring.connected_outputs or output.name in named
        is_fed = is_fed or bool(feeding[output.name])
        if is_known and output.name and not is_fed:
            message = (
                f"nothing feeds output '{output.name}' of {resolved.title}; no state has an output "
            )
            message += 'of that name. Add <connection output_state_id="..." output="..." '
            message += f'input_state_id="{resolved.chart.name}" input="{output.name}"/>.'
            yield Problem(output.position(), ProblemKind.UNFED_OUTPUT, message)
        yield from _check_feeds(output, feeding[output.name], resolved, wiring)
    yield from _check_pass_through(resolved)
    yield from _check_fed_by_name(resolved, flow)
    for (node, name), connection in wiring.into_machine.items():
        home = flow.outputs.get(node, {}).get(name, connection.input)
        if home != connection.input:
            message = f"'{name}' of '{node}' is read and written in one place, "
            message += f"'{home}', and cannot feed output '{connection.input}' too; "
            message += "put a state between that copies it."
            yield Problem(connection.position(), ProblemKind.CONFLICTING_OUTPUT, message)


def _check_fed_by_name(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each value that feeds a machine output by its name and lives elsewhere.

    The machine output would keep what another state has written before.
    """
    wiring = flow.wiring
    by_name = {port.name for port in resolved.chart.outputs} - wiring.connected_outputs
    for node, homes in flow.outputs.items() if by_name else ():
        for name, home in homes.items():
            if name not in by_name or home == name:
                continue
            entry = resolved.by_id[node]
            connection = wiring.into_machine.get((node, name)) or wiring.into_state.get(
                (node, name)
            )
            message = (
                f"output '{name}' of {label(entry.node)} lives in '{home}', so that it cannot "
            )
            message += f"feed output '{name}' of {resolved.title}, which all outputs of its name "
            message += "feed. Connect those that are to feed it, or rename one of the two."
            position = (connection or entry.node).position()
            yield Problem(position, ProblemKind.CONFLICTING_OUTPUT, message)


def _check_feeds(
    output: Output,
    feeding: Sequence[tuple[str, str]],
    resolved: ResolvedChart,
    wiring: Wiring,
) -> Iterator[Problem]:
    """Yield a problem for the first state that feeds a machine output with another type."""
    for node, name in feeding:
        port = resolved.by_id[node].use.outputs[name]
        if port.type == output.type or fits(port.type, output.type or None):
            continue
        connection = wiring.into_machine.get((node, name))
        position = output.position() if connection is None else connection.position()
        target = f"output '{output.name}' of {resolved.title}"
        yield from _check_flow(
            f"output '{name}' of '{node}'", port, target, output, position=position
        )
        return


def _check_pass_through(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem if an input and an output of one name have different types."""
    inputs = {port.name: port for port in resolved.chart.inputs}
    for output in resolved.chart.outputs:
        given = inputs.get(output.name)
        source = f"input '{output.name}' of {resolved.title}"
        target = "its output of the same name, which is the same value,"
        if given is not None:
            yield from _check_flow(source, given, target, output, position=output.position())


def check_defaults(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the defaults of the chart's inputs."""
    for port in resolved.chart.inputs:
        if not fits(type_of(port.default), port.type):
            message = f"the default of input '{port.name}' is {_shown(port.default)}; its type is "
            message += f"{port.type}."
            yield Problem(port.position("default"), ProblemKind.TYPE_CONFLICT, message)


def check_parameters(entry: ResolvedNode) -> Iterator[Problem]:
    """Yield the problems with what a state or behavior is given."""
    signature = entry.use.signature
    if signature is not None:
        yield from _check_values(entry, signature)
        yield from _check_required(entry, signature)
        inputs, outputs = signature.inputs, signature.outputs
        yield from _check_ports(entry, entry.node.inputs, inputs, ProblemKind.UNKNOWN_INPUT)
        yield from _check_ports(entry, entry.node.outputs, outputs, ProblemKind.UNKNOWN_OUTPUT)


def _check_values(entry: ResolvedNode, signature: Signature) -> Iterator[Problem]:
    """Yield the problems with values that are given."""
    known = {parameter.name: parameter for parameter in signature.parameters}
    for name, value in given_values(entry).items():
        parameter = known.get(name)
        if name and parameter is None:
            hint = names.allowed(name, known)
            message = f"{signature.title} has no parameter '{name}'; {hint}"
            yield Problem(_position(entry.node, name), ProblemKind.UNKNOWN_PARAMETER, message)
        elif parameter is not None and parameter.takes_source:
            if name != PARAMETER or value not in tuple(PREDICATES):
                position = _position(entry.node, name)
                yield _source_problem(parameter.name, signature, position)
        elif parameter is not None and not fits(type_of(value), parameter.type):
            message = f"parameter '{name}' of {signature.title} is {parameter.type}; found "
            message += f"{_shown(value)}."
            yield Problem(_position(entry.node, name, "value"), ProblemKind.PARAMETER_TYPE, message)
        elif (
            isinstance(value, str) and names.is_topic_parameter(name) and not names.is_topic(value)
        ):
            message = f"'{names.shortened(value)}' of {label(entry.node)} cannot name a topic; "
            message += f"allowed: {names.TOPIC_RULE}. Rename it, such as 'cell/done'."
            yield Problem(_position(entry.node, name, "value"), ProblemKind.INVALID_NAME, message)
    yield from _check_name_lists(entry, signature)
    if isinstance(entry.node, Behavior):
        yield from _check_dictionaries(entry.node)


def _check_name_lists(entry: ResolvedNode, signature: Signature) -> Iterator[Problem]:
    """Report a parameter that gives the outcomes or keys of a state and is no list of names."""
    if not isinstance(entry.use.declaration, StateClass):
        return
    state, values = entry.use.declaration, arguments(entry.node, entry.use.is_timed)
    for declared in dict.fromkeys((state.outcomes, state.inputs, state.outputs)):
        if isinstance(declared, FromParameter) and declared.parameter in values:
            value = values[declared.parameter]
            if not isinstance(value, tuple) or not all(
                isinstance(item, str) and names.is_name(item) for item in value
            ):
                message = f"parameter '{declared.parameter}' of {signature.title} names its "
                message += f"outcomes or keys; found {_shown(value)}, needed a list of names."
                position = _position(entry.node, declared.parameter, "value")
                yield Problem(position, ProblemKind.PARAMETER_TYPE, message)


def _check_dictionaries(node: Behavior) -> Iterator[Problem]:
    """Report dictionaries for a behavior: the FlexBE App cannot read them back there."""
    for param in node.params:
        if _holds_dictionary(param.value):
            message = f"parameter '{param.name}' of {label(node)} is a dictionary, which the "
            message += "FlexBE App cannot read inside use_behavior; give its values one by one."
            yield Problem(param.position("value"), ProblemKind.PARAMETER_TYPE, message)


def _holds_dictionary(value: Literal) -> bool:
    if isinstance(value, tuple):
        return any(map(_holds_dictionary, value))
    return isinstance(value, dict)


def _check_required(entry: ResolvedNode, signature: Signature) -> Iterator[Problem]:
    """Yield a problem for each parameter without default that is not given."""
    known = [parameter.name for parameter in signature.parameters]
    given = arguments(entry.node, entry.use.is_timed)
    meant = {names.misspelt(name, known) for name in given if name not in known}
    for parameter in signature.parameters:
        if parameter.required and parameter.name not in (*given, *meant):
            if parameter.takes_source:
                position = entry.node.position("type")
                yield _source_problem(parameter.name, signature, position)
                continue
            kind = f" ({parameter.type})" if parameter.type else ""
            message = f"{signature.title} needs the parameter '{parameter.name}'{kind}; add "
            message += f'<param name="{parameter.name}" value="..."/> to {label(entry.node)}.'
            yield Problem(entry.node.position(), ProblemKind.MISSING_PARAMETER, message)


def _source_problem(name: str, signature: Signature, position: Position) -> Problem:
    message = f"parameter '{name}' of {signature.title} takes Python source, which a chart never "
    if name == PARAMETER:
        message += f"carries; name one of the predicates {', '.join(PREDICATES)}."
    else:
        message += "carries; use a state class of your own that does this one thing."
    return Problem(position, ProblemKind.PARAMETER_SOURCE, message)


def _check_ports(
    entry: ResolvedNode,
    declared: Sequence[Input | Output],
    offered: Sequence[Port],
    code: ProblemKind,
) -> Iterator[Problem]:
    """Yield the problems with the `<input>` or `<output>` elements of a node."""
    known = {port.name: port for port in offered}
    word = "input" if code is ProblemKind.UNKNOWN_INPUT else "output"
    title = entry.use.signature.title if entry.use.signature else ""
    for port in declared:
        if port.name and port.name not in known:
            message = f"{title} has no {word} '{port.name}'; {names.allowed(port.name, known)}"
            yield Problem(port.position("name"), code, message)
        elif port.name and port.type and known[port.name].type not in (None, port.type):
            message = f"{word} '{port.name}' of {title} is {known[port.name].type}; "
            message += f"found {port.type}."
            yield Problem(port.position("type"), ProblemKind.TYPE_CONFLICT, message)


def _position(node: Node, parameter: str, attribute: str = "name") -> Position:
    """Return where a node gives a parameter: in a <param>, or in an attribute of its own."""
    for param in node.params:
        if param.name == parameter:
            return param.position(attribute)
    if isinstance(node, State) and parameter in ("topic", "timeout_s"):
        return node.position(parameter)
    return node.position()


def _shown(value: Literal) -> str:
    return f"{format_literal(value)} ({type_of(value) or 'null'})"
