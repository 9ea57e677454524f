"""Check that every state can be reached, and that every state can reach an end."""

from __future__ import annotations

from collections.abc import Iterator

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.graph import Graph, reachable
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.resolve import ResolvedChart, label


def check_reachability(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a problem for each state that is never entered, or never left for good."""
    if resolved.is_concurrent:
        return
    reached = reachable(
        [graph.initial], lambda name: (edge.target for edge in graph.leaving.get(name, ()))
    )
    for name, entry in resolved.by_id.items():
        if graph.initial in resolved.by_id and name not in reached:
            message = f"no path from the initial state '{graph.initial}' leads to "
            message += f"{label(entry.node)}; lead a transition to it, or delete it."
            yield Problem(entry.node.position(), Code.UNREACHABLE_STATE, message)
    # A target that does not exist may be an end, so only what is known to lead on is followed.
    ends = {edge.target for edge in graph.edges if edge.target not in resolved.by_id}
    ending = reachable(ends, lambda name: (edge.source for edge in graph.entering.get(name, ())))
    for name, entry in resolved.by_id.items():
        if name not in ending and name in reached and entry.node.transitions:
            message = f"from {label(entry.node)} no outcome of {resolved.title} can be reached; it "
            message += f"leads only to {_led_to(name, graph)}. Lead a transition to an outcome."
            yield Problem(entry.node.position(), Code.NO_WAY_OUT, message)


def _led_to(name: str, graph: Graph) -> str:
    """Return the states that can be reached from one, for a message."""
    found = reachable([name], lambda n: (edge.target for edge in graph.leaving.get(n, ())))
    return names.quoted(other for other in graph.ids if other in found)
