"""Check that every value is written before it is read, on every path, and by whom it should be.

The values written on all paths to a state are found by a forward analysis over sets of homes, each
set one integer with a bit per home. A state writes all its outputs when it ends with an outcome of
its own. Leaving by `timed_out` of a timer writes nothing. The event `exhausted` happens on a later
entry only, so it leaves with what all entries out of a loop through the state bring, and the
state's own outputs. A read that the analysis cannot prove is reported with a shortest path to it
that does not write the value.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping

from flexbe_synthesizer.core.data_flow import DataFlow, Key, Wiring
from flexbe_synthesizer.core.graph import Edge, Graph, shortest_path
from flexbe_synthesizer.core.model import Connection
from flexbe_synthesizer.core.problem import Code, Position, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, ResolvedNode, label


def check_data_flow(resolved: ResolvedChart, flow: DataFlow, graph: Graph) -> Iterator[Problem]:
    """Yield a problem for each read of a value that may be missing or another state's."""
    if graph.initial not in resolved.by_id:
        return
    writes = _writes(flow)
    bits = {home: 1 << index for index, home in enumerate(dict.fromkeys(flow.outputs.values()))}
    given = {port.name for port in resolved.chart.inputs}
    written = _written_before(
        graph,
        {node: sum(bits[home] for home in homes) for node, homes in writes.items()},
        sum(bits.get(home, 0) for home in given),
    )
    connections = Wiring(resolved).into_state
    for key, home in flow.inputs.items():
        if key.node not in written or home in given:
            continue
        entry = resolved.by_id[key.node]
        connection = connections.get(key)
        position = entry.node.position() if connection is None else connection.position()
        if not written[key.node] & bits[home]:
            yield from _check_written(key, home, position, entry, graph, writes)
        elif connection is not None:
            yield from _check_writer(key, home, connection, entry, graph, writes)


def _writes(flow: DataFlow) -> Mapping[str, frozenset[str]]:
    """Return the homes that each state writes."""
    writes: dict[str, set[str]] = {}
    for key, home in flow.outputs.items():
        writes.setdefault(key.node, set()).add(home)
    return {node: frozenset(homes) for node, homes in writes.items()}


def _written_before(graph: Graph, writes: Mapping[str, int], given: int) -> Mapping[str, int]:
    """Return, for each state that can be reached, the homes written on every path to it."""
    before: dict[str, int] = {graph.initial: given}
    spent: dict[str, int] = {}  # the homes written when a counted state is left exhausted

    def after(edge: Edge) -> int | None:
        """Return the homes written when the edge is taken, None if it is not known to be."""
        if edge.is_exhausted:
            return spent.get(edge.source)
        return before[edge.source] | (writes.get(edge.source, 0) if edge.executed else 0)

    def narrow(homes: dict[str, int], name: str, arriving: int) -> bool:
        """Keep what arrives on every edge; tell whether that changed anything."""
        old = homes.get(name)
        homes[name] = arriving if old is None else old & arriving
        return homes[name] != old

    waiting = deque([graph.initial])
    while waiting:
        for edge in graph.leaving.get(waiting.popleft(), ()):
            arriving = after(edge)
            if arriving is None:
                continue
            has_changed = narrow(before, edge.target, arriving)
            if graph.loops.get(edge.target) == graph.loops[edge.source]:
                own = writes.get(edge.target, 0) if _writes_when_left(edge.target, graph) else 0
                has_changed |= narrow(spent, edge.target, arriving | own)
            if has_changed:
                waiting.append(edge.target)
    return before


def _writes_when_left(name: str, graph: Graph) -> bool:
    """Tell whether a state that comes back to itself has written its outputs."""
    return all(
        edge.executed
        for edge in graph.leaving.get(name, ())
        if not edge.is_exhausted and graph.loops.get(edge.target) == graph.loops[name]
    )


def _check_written(
    key: Key,
    home: str,
    position: Position,
    entry: ResolvedNode,
    graph: Graph,
    writes: Mapping[str, frozenset[str]],
) -> Iterator[Problem]:
    """Report a value that is read before it is written, with the path."""
    if key.node == graph.initial:
        path = f"{key.node} is the initial state"
    else:
        path = _path_text(_unwritten_path(graph, key.node, home, writes))
    writers = " or ".join(f"'{node}'" for node, homes in writes.items() if home in homes)
    message = f"input '{key.name}' of {label(entry.node)} is read before {writers} has written it: "
    message += f"{path}. Lead that path through {writers}, or feed the input from elsewhere."
    yield Problem(position, Code.READ_BEFORE_WRITE, message)


def _unwritten_path(
    graph: Graph, goal: str, home: str, writes: Mapping[str, frozenset[str]]
) -> tuple[Edge, ...]:
    """Return a shortest path to a state on which the home is not written."""

    def is_silent(edge: Edge) -> bool:
        return not edge.executed or home not in writes.get(edge.source, ())

    silent = {name: tuple(filter(is_silent, edges)) for name, edges in graph.leaving.items()}
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
    path = (
        shortest_path(graph.initial, goal, proven)
        or shortest_path(graph.initial, goal, silent)
        or ()
    )
    return tuple(step for edge in path for step in (*(loop_before(edge) or ()), edge))


def _check_writer(
    key: Key,
    home: str,
    connection: Connection,
    entry: ResolvedNode,
    graph: Graph,
    writes: Mapping[str, frozenset[str]],
) -> Iterator[Problem]:
    """Report a value that another state may have written over, with the path."""
    meant = connection.output_state_id
    others = [
        node for node, homes in writes.items() if home in homes and node not in (meant, key.node)
    ]
    leaving = {
        name: edges if home not in writes.get(name, ()) else ()
        for name, edges in graph.leaving.items()
    }
    for other in others:
        start = {**leaving, other: tuple(e for e in graph.leaving.get(other, ()) if e.executed)}
        path = shortest_path(other, key.node, start)
        if path is not None:
            message = f"input '{key.name}' of {label(entry.node)} is to come from '{meant}', but "
            message += (
                f"'{other}' writes the same value, '{home}', on the way: {_path_text(path)}. "
            )
            message += "Let them feed different outputs of the chart."
            yield Problem(connection.position(), Code.OVERWRITTEN_VALUE, message)
            return


def _path_text(path: tuple[Edge, ...]) -> str:
    """Return the path as `A -failed-> B -done-> C`."""
    if not path:
        return "on some path"
    return path[0].source + "".join(f" -{edge.event}-> {edge.target}" for edge in path)
