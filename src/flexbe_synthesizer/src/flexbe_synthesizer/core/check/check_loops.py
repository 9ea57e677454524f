"""Warn of loops that nothing bounds."""

from __future__ import annotations

from collections.abc import Iterator

from flexbe_synthesizer.core.chart.names import EXHAUSTED
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.graph import Graph, path_text, shortest_path
from flexbe_synthesizer.core.library.resolve import ResolvedChart


def check_loops(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a warning for each knot of loops that no limit of attempts ends.

    A state whose attempts are spent still leads on, with `exhausted`.
    """
    by_id = resolved.by_id
    rest = graph.free
    # A knot that nothing leads out of is reported as an error.
    left = {
        rest.loops[edge.source]
        for edge in rest.edges
        if rest.loops[edge.source] != rest.loops.get(edge.target)
    }
    reported: set[int] = set()
    for name in by_id:
        loop = rest.loops.get(name)
        is_counted = by_id[name].node.attempts is not None
        if is_counted or name not in rest.looping or loop not in left or loop in reported:
            continue
        reported.add(loop)
        path = shortest_path(name, name, rest.leaving) or ()
        message = (
            f"nothing bounds the loop {path_text(path)}: while it fails, it continues forever. "
        )
        if any(edge.event == EXHAUSTED for edge in path):
            message += (
                f"Let '{EXHAUSTED}' lead out of it, or give another of its states ext:attempts."
            )
        else:
            message += "Give one of its states ext:attempts."
        yield Problem(by_id[name].node.position(), ProblemKind.UNBOUNDED_LOOP, message)
