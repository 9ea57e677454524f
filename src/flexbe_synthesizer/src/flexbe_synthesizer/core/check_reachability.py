"""Check that every state can be reached, and that every state can reach an end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.graph import Edge, Graph, reachable
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.resolve import EXHAUSTED, ResolvedChart, label


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
    ending = _ending(graph.edges, resolved)
    spent = _ending(_edges_when_spent(graph, resolved), resolved)
    for name, entry in resolved.by_id.items():
        if name not in reached or not entry.node.transitions:
            continue
        if name not in ending:
            message = f"from {label(entry.node)} no outcome of {resolved.title} can be reached; it "
            message += (
                f"leads only to {_led_to(name, graph.edges, graph)}. Lead a transition to an "
            )
            yield Problem(entry.node.position(), Code.NO_WAY_OUT, message + "outcome.")
        elif name not in spent and _is_left_exhausted(name, graph):
            found = _led_to(name, _edges_when_spent(graph, resolved), graph)
            message = f"once {label(entry.node)} has had its attempts, no outcome of "
            message += (
                f"{resolved.title} can be reached; '{EXHAUSTED}' leads only to {found}. Lead "
            )
            yield Problem(entry.node.position(), Code.NO_WAY_OUT, f"{message}it to an outcome.")


def _is_left_exhausted(name: str, graph: Graph) -> bool:
    return any(edge.is_exhausted for edge in graph.leaving.get(name, ()))


def _ending(edges: Iterable[Edge], resolved: ResolvedChart) -> set[str]:
    """Return the states from which some of the edges lead to an outcome.

    A target that does not exist may be an end, so only what is known to lead on is followed.
    """
    entering: dict[str, list[str]] = {}
    for edge in edges:
        entering.setdefault(edge.target, []).append(edge.source)
    ends = {target for target in entering if target not in resolved.by_id}
    return reachable(ends, lambda name: entering.get(name, ()))


def _edges_when_spent(graph: Graph, resolved: ResolvedChart) -> list[Edge]:
    """Return the edges that are left when all states that count attempts have had them.

    A state that never comes back to itself never runs out of attempts.
    """

    def is_spent(name: str) -> bool:
        if resolved.by_id[name].node.attempts is None:
            return False
        lasting = (e for e in graph.leaving.get(name, ()) if not e.is_exhausted)
        return any(graph.loops.get(edge.target) == graph.loops[name] for edge in lasting)

    spent = {name for name in graph.ids if is_spent(name)}
    return [e for e in graph.edges if e.source not in spent or e.event == EXHAUSTED]


def _led_to(start: str, edges: Iterable[Edge], graph: Graph) -> str:
    """Return the states that can be reached from one by some edges, for a message."""
    leaving: dict[str, list[str]] = {}
    for edge in edges:
        leaving.setdefault(edge.source, []).append(edge.target)
    found = reachable([start], lambda name: leaving.get(name, ()))
    return names.quoted(other for other in graph.ids if other in found)
