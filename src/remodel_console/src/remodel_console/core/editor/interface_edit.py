"""Changes to the values that a chart or container takes and gives; values in, values out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.literal import as_declared
from flexbe_synthesizer.core.chart.model import Chart, Connection, Input, Output
from flexbe_synthesizer.core.library.signature import is_type
from remodel_console.errors import CommandError

Port = TypeVar("Port", Input, Output)


def with_input(scope: Chart, place: int, name: str, kind: str, default: str) -> Chart:
    """Return the scope with one of its inputs changed, added or removed.

    Args:
        scope: chart or content of a container.
        place: index of the input; that behind the last adds one.
        name: its key; empty removes it, and what it fed.
        kind: its type; empty: any.
        default: the literal that it is if the caller gives none; empty: it must be given.

    Raises:
        CommandError: if the name or the type cannot be used.
    """
    value = as_declared(default, kind) if default else None
    port = Input(name, kind or None, value) if name else None
    flows = _followed(scope, _ends_of_input, scope.inputs[place : place + 1], port)
    return replace(scope, inputs=_put(scope.inputs, place, port), connections=flows)


def with_output(scope: Chart, place: int, name: str, kind: str) -> Chart:
    """Return the scope with one of its outputs changed, added or removed; see `with_input`."""
    port = Output(name, kind or None) if name else None
    flows = _followed(scope, _ends_of_output, scope.outputs[place : place + 1], port)
    return replace(scope, outputs=_put(scope.outputs, place, port), connections=flows)


def _put(ports: tuple[Port, ...], place: int, port: Port | None) -> tuple[Port, ...]:
    """Return the ports with another one at a place, or none."""
    if port is not None:
        _expect_usable(port, {other.name for i, other in enumerate(ports) if i != place})
    changed = list(ports)
    changed[place : place + 1] = [] if port is None else [port]
    return tuple(changed)


def _expect_usable(port: Input | Output, taken: set[str]) -> None:
    if not names.is_key(port.name):
        raise CommandError(f"'{port.name}' is no key: letters, digits and '_', no digit first")
    if port.name in taken:
        raise CommandError(f"there is a value '{port.name}' already")
    if port.type is not None and not is_type(port.type):
        raise CommandError(
            f"'{port.type}' is no type; there are bool, int, float, string, list, dict, and ROS "
            "messages such as geometry_msgs/PoseStamped"
        )


def _ends_of_input(flow: Connection, scope: str, old: str, new: str) -> Connection | None:
    """Return a connection with an input of the scope renamed; None if it names another."""
    return (
        replace(flow, output=new) if (flow.output_state_id, flow.output) == (scope, old) else None
    )


def _ends_of_output(flow: Connection, scope: str, old: str, new: str) -> Connection | None:
    """Return a connection with an output of the scope renamed; None if it names another."""
    return replace(flow, input=new) if (flow.input_state_id, flow.input) == (scope, old) else None


def _followed(
    scope: Chart,
    rename: Callable[[Connection, str, str, str], Connection | None],
    old: tuple[Input | Output, ...],
    port: Input | Output | None,
) -> tuple[Connection, ...]:
    """Return the connections of a scope that follow a port's new name, or go with it."""
    if not old:
        return scope.connections
    found = []
    for flow in scope.connections:
        renamed = rename(flow, scope.name, old[0].name, port.name if port else "")
        if renamed is None:
            found.append(flow)
        elif port is not None:
            found.append(renamed)
    return tuple(found)
