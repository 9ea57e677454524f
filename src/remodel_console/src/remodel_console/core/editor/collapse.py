"""Large charts, drawn with their containers closed: what is open lies on the path of interest."""

from __future__ import annotations

from dataclasses import replace

from flexbe_synthesizer.core.chart.model import AnyNode, Chart, Container, State, walk_nodes
from remodel_console.core.editor.editing import Path

CLOSED = "states inside"  # with their number, the type of a container that is drawn closed
_MOST_OPEN = 40  # states and containers that are readable in one drawing


def collapsed(chart: Chart, path: Path) -> Chart:
    """Return a chart to be drawn; a large one has all containers closed that are not on a path."""
    is_small = sum(1 for _ in walk_nodes(chart)) <= _MOST_OPEN
    return chart if is_small else _closed_beside(chart, path)


def _closed_beside(scope: Chart, path: Path) -> Chart:
    return replace(scope, nodes=tuple(_closed(node, path) for node in scope.nodes))


def _closed(node: AnyNode, path: Path) -> AnyNode:
    """Return a node as it is drawn: a closed container as a state that says how large it is."""
    if not isinstance(node, Container):
        return node
    if path and node.id == path[0]:
        return replace(node, body=_closed_beside(node.body, path[1:]))
    count = sum(not isinstance(inner, Container) for inner in walk_nodes(node.body))
    return State(
        id=node.id,
        type=f"{count} {CLOSED}",
        transitions=node.transitions,
        attempts=node.attempts,
        timeout_s=node.timeout_s,
        on_error=node.on_error,
        at=node.at,
    )
