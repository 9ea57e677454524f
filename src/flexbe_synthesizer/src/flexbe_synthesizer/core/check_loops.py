"""Warn of loops that nothing bounds."""

from __future__ import annotations

from collections.abc import Iterator

from flexbe_synthesizer.core.graph import Graph, path_text, shortest_path
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart


def check_loops(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a warning for each knot of loops in which no state has a limit of attempts."""
    by_id = resolved.by_id
    free = [n for n in graph.ids if n in graph.looping and by_id[n].node.attempts is None]
    if not free:
        return
    known = set(free)
    edges = {name: [e for e in graph.leaving.get(name, ()) if e.target in known] for name in free}
    rest = Graph(graph.initial, tuple(free), edges)
    # A knot that nothing leads out of is an error, and told as one.
    left = {
        rest.loops[edge.source]
        for edge in graph.edges
        if edge.source in known and rest.loops[edge.source] != rest.loops.get(edge.target)
    }
    told: set[int] = set()
    for name in by_id:
        loop = rest.loops.get(name)
        if name not in rest.looping or loop not in left or loop in told:
            continue
        told.add(loop)
        path = shortest_path(name, name, rest.leaving)
        message = (
            f"nothing bounds the loop {path_text(path or ())}: while it fails, it goes on for "
        )
        message += "ever. Give one of its states ext:attempts."
        yield Problem(by_id[name].node.position(), Code.UNBOUNDED_LOOP, message)
