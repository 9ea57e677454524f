"""Check that every value is written before it is read, on every path, and by whom it should be.

A read that `written` cannot prove is reported with a shortest path to it that does not write the
value.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

from flexbe_synthesizer.core.chart.model import Connection, State
from flexbe_synthesizer.core.chart.names import ERROR_CODE
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import DataFlow, label
from flexbe_synthesizer.core.library.definite_assignment import Values
from flexbe_synthesizer.core.library.graph import Edge, path_text, shortest_path
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode

_MOST_PATHS = 50  # problems of a chart that are reported with their path; each is a search
_MOST_WRITERS = 12  # named in a message


def check_data_flow(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each read of a value that may be missing or another state's."""
    flow = resolved.flow
    if resolved.is_concurrent:
        yield from _check_simultaneous(resolved, flow)
        return
    if resolved.graph.initial not in resolved.by_id:
        return
    values = resolved.values
    given = {port.name for port in resolved.chart.inputs}
    written = values.written_before
    paths_left = _MOST_PATHS
    for node, homes in flow.inputs.items():
        if node not in written:
            continue
        for name, home in homes.items():
            connection = flow.wiring.into_state.get((node, name))
            if home not in given and not values.has(written[node], home):
                read = _Read(resolved.by_id[node], name, home, connection)
                yield _missing(read, values, paths_left > 0)
                paths_left -= 1
            elif connection is not None and len(values.writers.get(home, ())) > 1:
                if connection.output_state_id not in resolved.by_id:
                    continue
                read = _Read(resolved.by_id[node], name, home, connection)
                expected = _expected(read, connection, flow)
                other = values.last_writers.besides(expected, home, node)
                if other is not None:
                    yield _overwritten(
                        read, connection, other, values, is_path_shown=paths_left > 0
                    )
                    paths_left -= 1


def _expected(read: _Read, connection: Connection, flow: DataFlow) -> tuple[str, ...]:
    """Return who may have written a value last: its source, and a reader that changes it."""
    reader = read.entry.node.id
    changes_it = flow.outputs.get(reader, {}).get(read.name) == read.home
    return (connection.output_state_id, *((reader,) * changes_it))


def _check_simultaneous(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each read of what a state that runs at the same time writes."""
    given = {port.name for port in resolved.chart.inputs}
    for node, name, home in (
        (n, *item) for n, homes in flow.inputs.items() for item in homes.items()
    ):
        connection = flow.wiring.into_state.get((node, name))
        if home not in given and connection is not None:
            message = f"{_Read(resolved.by_id[node], name, home, connection)} is to come from "
            message += f"'{connection.output_state_id}', which runs at the same time and may not "
            message += f"have written it: {node} starts with the container. Move one of them out "
            message += f"of the container '{resolved.chart.name}'."
            yield Problem(connection.position(), ProblemKind.READ_BEFORE_WRITE, message)


class _Read(NamedTuple):
    """An input of a node, the home that it reads, and the connection that says so."""

    entry: ResolvedNode
    name: str
    home: str
    connection: Connection | None

    def __str__(self) -> str:
        return f"input '{self.name}' of {label(self.entry.node)}"


def _missing(read: _Read, values: Values, is_path_shown: bool) -> Problem:
    """Return the problem of a value that is read before it is written, with the path."""
    reader, home = read.entry.node.id, read.home
    path = f"{reader} is the initial state"
    edges: tuple[Edge, ...] = ()
    if reader != values.graph.initial:
        edges = _unwritten_path(reader, home, values) if is_path_shown else ()
        path = path_text(edges)
    nodes = dict.fromkeys(values.writers[home])
    writers = " or ".join(f"'{node}'" for node in islice(nodes, _MOST_WRITERS))
    message = f"{read} is read before {writers} has written it: {path}. "
    silent = next((edge for edge in edges if edge.executed and edge.source in nodes), None)
    if silent is not None:
        how = "always write" if values.has(values.touched_on(silent), home) else "write"
        message += f"'{silent.source}' does not {how} it when it ends with '{silent.event}'. "
    message += f"Route that path through {writers}, or feed the input from elsewhere."
    position = (read.connection or read.entry.node).position()
    return Problem(position, ProblemKind.READ_BEFORE_WRITE, message)


def _unwritten_path(reader: str, home: str, values: Values) -> tuple[Edge, ...]:
    """Return a shortest path to a state on which the home is not written."""
    silent = values.edges_not_writing(home)
    lasting = {
        name: tuple(edge for edge in edges if not edge.is_exhausted)
        for name, edges in silent.items()
    }

    def loop_before(edge: Edge) -> tuple[Edge, ...] | None:
        """Return the loop through a counted state that comes before it is left exhausted."""
        return shortest_path(edge.source, edge.source, lasting) if edge.is_exhausted else ()

    proven = {
        name: tuple(edge for edge in edges if loop_before(edge) is not None)
        for name, edges in silent.items()
    }
    initial = values.graph.initial
    path = shortest_path(initial, reader, proven) or shortest_path(initial, reader, silent) or ()
    return tuple(step for edge in path for step in (*(loop_before(edge) or ()), edge))


def _overwritten(
    read: _Read, connection: Connection, other: str, values: Values, is_path_shown: bool
) -> Problem:
    """Return the problem of a value that another state may have written over, with the path."""
    path = _overwriting_path(read, other, values) if is_path_shown else ()
    message = f"{read} is to come from '{connection.output_state_id}', but '{other}' writes the "
    message += f"same value, '{read.home}', on the way: {path_text(path)}. Let them feed different "
    message += "outputs of the chart."
    return Problem(connection.position(), ProblemKind.OVERWRITTEN_VALUE, message)


def _overwriting_path(read: _Read, other: str, values: Values) -> tuple[Edge, ...]:
    """Return a shortest path from a state that writes the home to the one that reads it."""
    leaving = values.edges_not_writing(read.home)
    leaving[other] = tuple(
        edge
        for edge in values.graph.leaving.get(other, ())
        if values.has(values.touched_on(edge), read.home)
    )
    return shortest_path(other, read.entry.node.id, leaving) or ()


# Check that values which share a home are not taken for each other.
#
# Outputs that feed one output of the chart are one value. Who reads one of them by a connection, or
# routes failures by it, must not get another output of the same state; and what is inside a
# container must not find that the container itself has written over what it reads.


def check_homes(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the problems with values that share a home."""
    yield from _check_reads(resolved, flow)
    yield from _check_containers(resolved, flow)
    yield from _check_routes(resolved, flow)
    if resolved.is_concurrent:
        yield from _check_races(resolved, flow)


def _check_reads(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each connection whose value another output can replace."""
    for (taker, name), connection in flow.wiring.into_state.items():
        giver, output = connection.output_state_id, connection.output
        home = flow.outputs.get(giver, {}).get(output)
        if home is None or flow.inputs.get(taker, {}).get(name) != home:
            continue
        read = f"input '{name}' of {label(resolved.by_id[taker].node)}"
        other = _other_output(giver, output, flow)
        if other is not None:
            message = f"{read} is to come from '{output}' of '{giver}', whose output '{other}' is "
            message += f"the same value, '{home}'. Let them feed different outputs of the chart."
            yield Problem(connection.position(), ProblemKind.OVERWRITTEN_VALUE, message)


def _check_containers(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each container that writes over what is still read inside it."""
    for name, inputs in flow.inputs.items():
        entry = resolved.by_id[name]
        if isinstance(entry.node, State):
            continue  # it reads before it writes
        for key, home in inputs.items():
            own = [o for o, at in flow.outputs.get(name, {}).items() if at == home and o != key]
            if own:
                message = f"input '{key}' of {label(entry.node)} is the same value, '{home}', as "
                message += f"its output '{own[0]}', and may be overwritten while it is still "
                message += "read. Let the output feed another output of the chart."
                connection = flow.wiring.into_state.get((name, key))
                place = (connection or entry.node).position()
                yield Problem(place, ProblemKind.OVERWRITTEN_VALUE, message)


def _check_routes(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each state whose failures are routed by a value that is not the code."""
    for name, entry in resolved.by_id.items():
        if entry.node.on_error and ERROR_CODE in flow.outputs.get(name, {}):
            other = _other_output(name, ERROR_CODE, flow)
            if other is not None:
                message = f"ext:on_error of {label(entry.node)} reads '{ERROR_CODE}', and its "
                message += f"output '{other}' is the same value, "
                message += f"'{flow.outputs[name][ERROR_CODE]}'. Let them feed different outputs "
                message += "of the chart."
                yield Problem(
                    entry.node.position("on_error"), ProblemKind.OVERWRITTEN_VALUE, message
                )


def _check_races(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield a problem for each input of the container that one state reads and another writes."""
    given = {port.name for port in resolved.chart.inputs}
    writers: dict[str, list[str]] = {}
    for name, homes in flow.outputs.items():
        for home in set(homes.values()) & given:
            writers.setdefault(home, []).append(name)
    for taker, inputs in flow.inputs.items():
        for name, home in inputs.items():
            others = [other for other in writers.get(home, ()) if other != taker]
            if others:
                entry = resolved.by_id[taker]
                message = f"input '{name}' of {label(entry.node)} reads '{home}' of "
                message += f"{resolved.title}, which '{others[0]}' writes at the same time, before "
                message += f"or after. Let '{others[0]}' feed an output of another name."
                connection = flow.wiring.into_state.get((taker, name))
                yield Problem(
                    (connection or entry.node).position(), ProblemKind.OVERWRITTEN_VALUE, message
                )


def _other_output(name: str, output: str, flow: DataFlow) -> str | None:
    """Return another output of a node with the home of this one."""
    homes = flow.outputs[name]
    return next((o for o, home in homes.items() if home == homes[output] and o != output), None)
