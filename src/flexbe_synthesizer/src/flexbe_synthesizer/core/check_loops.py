"""Warn of loops that nothing bounds."""

from __future__ import annotations

from collections.abc import Iterator

from flexbe_synthesizer.core.graph import Graph, path_text, shortest_path
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart


def check_loops(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a warning for each knot of loops in which no state has a limit of attempts."""
    free = [name for name in graph.ids if resolved.by_id[name].node.attempts is None]
    known = set(free)
    edges = tuple(e for e in graph.edges if e.source in known and e.target in known)
    rest = Graph(graph.initial, tuple(free), edges)
    told: set[int] = set()
    for name in resolved.by_id:
        if name not in known or rest.loops[name] in told:
            continue
        path = shortest_path(name, name, rest.leaving)
        if path is not None and _has_exit(rest.loops[name], rest, graph):
            told.add(rest.loops[name])
            message = f"nothing bounds the loop {path_text(path)}: while it fails, it goes on for "
            message += "ever. Give one of its states ext:attempts."
            yield Problem(resolved.by_id[name].node.position(), Code.UNBOUNDED_LOOP, message)


def _has_exit(loop: int, rest: Graph, graph: Graph) -> bool:
    """Tell whether something leads out of a knot of loops; if nothing does, that is an error."""
    return any(
        rest.loops.get(edge.source) == loop and rest.loops.get(edge.target) != loop
        for edge in graph.edges
    )
