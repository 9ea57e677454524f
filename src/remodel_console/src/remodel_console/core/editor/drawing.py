"""Which part of a drawing an active state is; behaviors drawn open, large charts collapsed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Container,
    State,
    walk_nodes,
)
from flexbe_synthesizer.core.machine.expanded_labels import RUN, TIMER
from remodel_console.core.editor.editing import Path

_DEEPEST = 4  # behaviors inside behaviors that are drawn open


def drawn_path(engine_path: str, drawn: frozenset[str]) -> str:
    """Return the path in the drawing of what is active in the engine; empty if nothing is drawn.

    What synthesis added to a state is drawn as that state, and what lies deeper than the drawing
    goes as the box around it.

    Args:
        engine_path: as the engine publishes it, `/Place/Insert_attempts`.
        drawn: paths in the drawing, `Place/Insert`.
    """
    found: list[str] = []
    for part in engine_path.strip("/").split("/"):
        names = (part, part.removesuffix("_attempts"), part.removesuffix("_error"))
        deeper = next((n for n in names if "/".join((*found, n)) in drawn), None)
        if deeper is not None:
            found.append(deeper)
        elif part not in (RUN, TIMER):  # of a container that keeps a state's time
            break
    return "/".join(found)


def engine_paths(chart: Chart, path: str) -> frozenset[str]:
    """Return the paths that the engine may have for a state in the drawing, `Place/Insert`.

    Synthesis puts what has a timeout into a container, as its state `run`, unless it keeps the
    time itself, which a chart alone does not say.
    """
    found, scope = {""}, chart
    for part in path.split("/"):
        node = next((node for node in scope.nodes if node.id == part), None)
        if node is None:
            return frozenset()
        found = {f"{above}/{part}" for above in found}
        if node.timeout_s is not None:
            found |= {f"{inside}/{RUN}" for inside in found}
        scope = node.body if isinstance(node, Container) else Chart(part, "")
    return frozenset(found)


def drawn_paths(chart: Chart, prefix: str = "") -> frozenset[str]:
    """Return the paths of all that a drawing of a chart shows."""
    paths: set[str] = set()
    for node in chart.nodes:
        path = f"{prefix}{node.id}"
        paths.add(path)
        if isinstance(node, Container):
            paths |= drawn_paths(node.body, f"{path}/")
    return frozenset(paths)


@dataclass(frozen=True)
class Opened:
    """Charts by display name and by the path that other charts call them by."""

    by_name: dict[str, Chart]

    def inside(self, chart: Chart, depth: int = 0) -> Chart:
        """Return a chart with the behaviors in it as containers of what they do, to be drawn."""
        return replace(chart, nodes=tuple(self._opened(node, depth) for node in chart.nodes))

    def _opened(self, node: AnyNode, depth: int) -> AnyNode:
        if isinstance(node, Container):
            return replace(node, body=self.inside(node.body, depth))
        found = self.by_name.get(node.type) if isinstance(node, Behavior) else None
        if found is None or depth >= _DEEPEST:
            return node
        body = replace(self.inside(found, depth + 1), name=node.id)
        return Container(
            id=node.id,
            type="container",
            transitions=node.transitions,
            attempts=node.attempts,
            timeout_s=node.timeout_s,
            on_error=node.on_error,
            at=node.at,
            body=body,
        )


def opened(chart: Chart, others: Iterable[Chart]) -> Chart:
    """Return a chart with the behaviors in it drawn open, where another chart says what they do."""
    by_name = {other.name: other for other in others}
    by_name |= {other.file.rpartition("/")[2]: other for other in by_name.values()}
    if not any(isinstance(node, Behavior) for node in walk_nodes(chart)):
        return chart
    return Opened(by_name).inside(chart)


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
