"""Check that every state can be reached, and that every state can reach an end."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.names import EXHAUSTED
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.graph import Graph, reachable
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.use import label

_MOST_LISTED = 50  # dead ends that are reported with all that they lead to
_MORE = "states that do not end either"


def check_reachability(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a problem for each state that is never entered, or never left for good."""
    if resolved.is_concurrent:
        return
    by_id, reached, initial = resolved.by_id, graph.reached, graph.initial
    if initial not in by_id:
        return
    for name, entry in by_id.items():
        if name not in reached:
            message = f"no path from the initial state '{initial}' leads to "
            message += f"{label(entry.node)}; add a transition to it, or delete it."
            yield Problem(entry.node.position(), ProblemKind.UNREACHABLE_STATE, message)
    spent = _spent(graph, resolved)
    ending_when_spent = _ending(graph, spent)
    if ending_when_spent >= reached:
        return
    ending, shown = _ending(graph, frozenset()), _MOST_LISTED
    for name, entry in by_id.items():
        if name in ending_when_spent or name not in reached or not entry.node.transitions:
            continue
        shown -= 1
        if name not in ending:
            message = f"from {label(entry.node)} no outcome of {resolved.title} can be reached; it "
            found = _led_to(name, graph, frozenset()) if shown >= 0 else _MORE
            message += f"leads only to {found}. Add a transition to an "
            yield Problem(entry.node.position(), ProblemKind.NO_WAY_OUT, message + "outcome.")
        elif any(edge.is_exhausted for edge in graph.leaving.get(name, ())):
            message = f"once {label(entry.node)} has had its attempts, no outcome of "
            message += f"{resolved.title} can be reached; '{EXHAUSTED}' leads only to "
            message += f"{_led_to(name, graph, spent) if shown >= 0 else _MORE}. Lead it to an "
            message += "outcome."
            yield Problem(entry.node.position(), ProblemKind.NO_WAY_OUT, message)


def _spent(graph: Graph, resolved: ResolvedChart) -> frozenset[str]:
    """Return the states that can have had all their attempts.

    A state that never leads to itself never runs out of attempts, unless the container that it
    is in is entered again.
    """
    if resolved.is_repeated:
        return frozenset(graph.counted)
    loops = graph.loops
    return frozenset(
        name
        for name in graph.counted
        for edge in graph.leaving.get(name, ())
        if not edge.is_exhausted and loops.get(edge.target) == loops[name]
    )


def _ending(graph: Graph, spent: Collection[str]) -> set[str]:
    """Return the states from which an outcome can be reached when some have had their attempts.

    A target that does not exist may be an end, so only what is known to lead on is followed.
    """
    entering, known = graph.entering, set(graph.ids)
    found = {target for target in entering if target not in known}
    waiting = list(found)
    while waiting:
        for edge in entering.get(waiting.pop(), ()):
            leads_on = edge.source not in spent or edge.event == EXHAUSTED
            if leads_on and edge.source not in found:
                found.add(edge.source)
                waiting.append(edge.source)
    return found


def _led_to(start: str, graph: Graph, spent: Collection[str]) -> str:
    """Return the states that can be reached from one when some have had their attempts."""
    found = reachable(
        [start],
        lambda name: [
            edge.target
            for edge in graph.leaving.get(name, ())
            if edge.source not in spent or edge.event == EXHAUSTED
        ],
    )
    return names.quoted(other for other in graph.ids if other in found)
