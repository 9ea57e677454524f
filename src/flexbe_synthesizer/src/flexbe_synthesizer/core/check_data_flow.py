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
from collections.abc import Container, Iterator, Mapping

from flexbe_synthesizer.core.data_flow import DataFlow, Wiring
from flexbe_synthesizer.core.graph import Edge, Graph, shortest_path
from flexbe_synthesizer.core.model import Connection
from flexbe_synthesizer.core.problem import Code, Position, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, label


def check_data_flow(resolved: ResolvedChart, flow: DataFlow, graph: Graph) -> Iterator[Problem]:
    """Yield a problem for each read of a value that may be missing or another state's."""
    if graph.initial not in resolved.by_id:
        return
    values = _Values(graph, flow)
    bits = {home: 1 << index for index, home in enumerate(values.writers)}
    given = {port.name for port in resolved.chart.inputs}
    written = _written_before(
        graph,
        {node: sum(bits[home] for home in homes) for node, homes in values.homes.items()},
        sum(bits.get(home, 0) for home in given),
    )
    connections = Wiring(resolved).into_state
    for key, home in flow.inputs.items():
        if key.node not in written or home in given:
            continue
        entry = resolved.by_id[key.node]
        connection = connections.get(key)
        position = entry.node.position() if connection is None else connection.position()
        what = f"input '{key.name}' of {label(entry.node)}"
        if not written[key.node] & bits[home]:
            yield _missing(what, key.node, home, position, values)
        elif connection is not None:
            yield from _find_overwriting(what, key.node, home, connection, values, written)


class _Values:
    """Who writes which home, and the paths between."""

    def __init__(self, graph: Graph, flow: DataFlow) -> None:
        self.graph = graph
        self.homes: dict[str, set[str]] = {}
        self.writers: dict[str, list[str]] = {}
        for key, home in flow.outputs.items():
            self.homes.setdefault(key.node, set()).add(home)
            self.writers.setdefault(home, []).append(key.node)

    def edges_not_writing(self, home: str) -> dict[str, tuple[Edge, ...]]:
        """Return the edges from each state that are taken without writing the home."""
        silent = dict(self.graph.leaving)
        for node in self.writers[home]:
            silent[node] = tuple(e for e in silent.get(node, ()) if not e.executed)
        return silent


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


def _missing(what: str, reader: str, home: str, position: Position, values: _Values) -> Problem:
    """Return the problem of a value that is read before it is written, with the path."""
    path = f"{reader} is the initial state"
    if reader != values.graph.initial:
        path = _path_text(_unwritten_path(reader, home, values))
    writers = " or ".join(f"'{node}'" for node in dict.fromkeys(values.writers[home]))
    message = f"{what} is read before {writers} has written it: {path}. Lead that path through "
    message += f"{writers}, or feed the input from elsewhere."
    return Problem(position, Code.READ_BEFORE_WRITE, message)


def _unwritten_path(reader: str, home: str, values: _Values) -> tuple[Edge, ...]:
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


def _find_overwriting(
    what: str,
    reader: str,
    home: str,
    connection: Connection,
    values: _Values,
    reached: Container[str],
) -> Iterator[Problem]:
    """Yield a problem if another state may have written over a value, with the path."""
    meant = connection.output_state_id
    for other in values.writers[home]:
        if other in (meant, reader) or other not in reached:
            continue
        leaving = values.edges_not_writing(home)
        leaving[other] = tuple(e for e in values.graph.leaving.get(other, ()) if e.executed)
        path = shortest_path(other, reader, leaving)
        if path is not None:
            message = f"{what} is to come from '{meant}', but '{other}' writes the same value, "
            message += f"'{home}', on the way: {_path_text(path)}. Let them feed different "
            message += "outputs of the chart."
            yield Problem(connection.position(), Code.OVERWRITTEN_VALUE, message)
            return


def _path_text(path: tuple[Edge, ...]) -> str:
    """Return the path as `A -failed-> B -done-> C`."""
    if not path:
        return "on some path"
    return path[0].source + "".join(f" -{edge.event}-> {edge.target}" for edge in path)
