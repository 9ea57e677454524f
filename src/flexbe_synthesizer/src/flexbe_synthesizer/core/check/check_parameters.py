"""Check parameters and declared inputs and outputs against what the state or behavior offers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.literal import Literal, format_literal, type_of
from flexbe_synthesizer.core.chart.model import Behavior, Input, Node, Output, State
from flexbe_synthesizer.core.chart.problem import Position, Problem, ProblemKind
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode, given_values
from flexbe_synthesizer.core.library.signature import (
    FromParameter,
    Port,
    Signature,
    StateClass,
    fits,
)
from flexbe_synthesizer.core.library.use import arguments, label
from flexbe_synthesizer.core.machine.machine import PARAMETER, PREDICATES


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
