"""Changes to how a container runs what is in it, and to what ends it; values in, values out."""

from __future__ import annotations

from dataclasses import replace

from flexbe_synthesizer.core.chart.model import Chart, Condition, Container, ContainerKind, When
from remodel_console.core.editor.chart_edit import node_at
from remodel_console.core.editor.editing import Path

KIND_WORDS = {
    ContainerKind.SEQUENCE: "sequential",
    ContainerKind.CONCURRENCY: "concurrent",
    ContainerKind.PRIORITY: "sequential, with priority over everything else",
}


def kind_at(chart: Chart, path: Path) -> ContainerKind:
    """Return how what is in a container runs; the chart itself runs one after another."""
    node = node_at(chart, path)
    return node.runs if isinstance(node, Container) else ContainerKind.SEQUENCE


def with_kind(scope: Chart, node_id: str, kind: ContainerKind) -> Chart:
    """Return the scope with a container that runs otherwise.

    What runs all at once has no first state and no transitions, and what does not, no conditions.
    """
    nodes = tuple(
        replace(node, type=kind.value, body=_fitted(node.body, kind))
        if isinstance(node, Container) and node.id == node_id
        else node
        for node in scope.nodes
    )
    return replace(scope, nodes=nodes)


def _fitted(body: Chart, kind: ContainerKind) -> Chart:
    if kind is ContainerKind.CONCURRENCY:
        nodes = tuple(replace(node, transitions=()) for node in body.nodes)
        return replace(body, initial="", nodes=nodes)
    first = body.initial or next((node.id for node in body.nodes), "")
    return replace(body, initial=first, conditions=())


def with_condition(
    body: Chart, place: int, outcome: str, pairs: tuple[tuple[str, str], ...]
) -> Chart:
    """Return a container's content with a condition changed, added or removed.

    Args:
        body: content of a container that runs all at once.
        place: index of the condition; that behind the last adds one.
        outcome: that it ends with; empty removes the condition.
        pairs: (state, event)s that all must have happened.
    """
    conditions = list(body.conditions)
    conditions[place : place + 1] = (
        [Condition(outcome, tuple(When(*pair) for pair in pairs))] if outcome else []
    )
    return replace(body, conditions=tuple(conditions))
