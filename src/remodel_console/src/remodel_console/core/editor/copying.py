"""Copies of states: what belongs to them goes with them, and ids that are taken change."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import AnyNode, Chart, Connection
from remodel_console.core.editor.chart_edit import node_at, renamed, unused_id, with_node
from remodel_console.core.editor.editing import Path, container_at


@dataclass(frozen=True)
class Copied:
    """States that were copied out of one container, and the data flow between them."""

    nodes: tuple[AnyNode, ...] = ()
    connections: tuple[Connection, ...] = ()


def outermost(paths: Iterable[Path]) -> tuple[Path, ...]:
    """Return the paths that lie in none of the others, in order."""
    given = tuple(dict.fromkeys(path for path in paths if path))
    return tuple(
        path
        for path in given
        if not any(path != other and path[: len(other)] == other for other in given)
    )


def copied(chart: Chart, paths: Iterable[Path]) -> Copied:
    """Return copies of the nodes of these paths that are in the container of the first."""
    wanted = outermost(paths)
    if not wanted:
        return Copied()
    beside = [path for path in wanted if path[:-1] == wanted[0][:-1]]
    nodes = tuple(node for path in beside if (node := node_at(chart, path)) is not None)
    ids = {node.id for node in nodes}
    flows = container_at(chart, wanted[0][:-1]).connections
    inside = (flow for flow in flows if {flow.output_state_id, flow.input_state_id} <= ids)
    return Copied(nodes, tuple(inside))


def pasted(scope: Chart, what: Copied) -> tuple[Chart, tuple[str, ...]]:
    """Return the scope with copies added, and their ids.

    A transition to what is neither copied with it nor in the scope leads nowhere in the copy.
    """
    part = Chart("", "", nodes=what.nodes, connections=what.connections)
    for node in what.nodes:
        taken = Chart("", "", (*scope.outcomes,), (*scope.nodes, *part.nodes))
        if unused_id(scope, node.id) != node.id:
            part = renamed(part, node.id, unused_id(taken, node.id))
    ids = tuple(node.id for node in part.nodes)
    targets = {*ids, *(node.id for node in scope.nodes), *(o.name for o in scope.outcomes)}
    for node in part.nodes:
        led = tuple(t for t in node.transitions if t.target in targets)
        routes = tuple(route for route in node.on_error if route.target in targets)
        scope = with_node(scope, replace(node, transitions=led, on_error=routes, at=None))
    return replace(scope, connections=(*scope.connections, *part.connections)), ids
