"""How often the states of a chart or container can be visited in one run, at most.

A run is cut into stretches at each visit to a state with `ext:attempts`. Within a stretch a state
is visited once, or nothing bounds it; so its visits are bounded by the stretches that can come to
it. The bound may be larger than what a run can reach, never smaller.
"""

from __future__ import annotations

from collections.abc import Mapping

from flexbe_synthesizer.core.graph import Edge, Graph
from flexbe_synthesizer.core.resolve import EXHAUSTED, ResolvedChart
from flexbe_synthesizer.core.written import Steps

Bound = int | None  # None: nothing bounds it


def most_visits(resolved: ResolvedChart, graph: Graph, entries: Bound) -> Mapping[str, Bound]:
    """Return how often each state of a chart or container runs at most; `entries`: how often it."""
    if resolved.is_concurrent:
        return dict.fromkeys(resolved.by_id, entries)
    attempts = {
        name: entry.node.attempts
        for name, entry in resolved.by_id.items()
        if entry.node.attempts is not None
    }
    free = free_graph(resolved, graph)
    starts = [graph.initial, *attempts]  # of the stretches, by bit
    weights = [entries, *(_least(attempts[n], graph, n, entries) for n in attempts)]
    totals: dict[int, Bound] = {0: 0}
    visits: dict[str, Bound] = {}
    for name, mask in _reaching(starts, free, graph, attempts).items():
        if mask not in totals:
            totals[mask] = _total(weights, mask)
        most = totals[mask]
        if mask and name in free.looping and name not in attempts:
            most = None
        limits = (most, attempts.get(name), None if name in graph.looping else entries)
        visits[name] = min((limit for limit in limits if limit is not None), default=None)
    return visits


def _total(weights: list[Bound], mask: int) -> Bound:
    """Return the sum of the weights of a set of stretches."""
    total = 0
    while mask:
        weight = weights[(mask & -mask).bit_length() - 1]
        if weight is None:
            return None
        total += weight
        mask &= mask - 1
    return total


def free_graph(resolved: ResolvedChart, graph: Graph) -> Graph:
    """Return the graph without what states with `ext:attempts` lead to when they run."""

    def is_free(edge: Edge) -> bool:
        return edge.event == EXHAUSTED or resolved.by_id[edge.source].node.attempts is None

    leaving = {name: list(filter(is_free, edges)) for name, edges in graph.leaving.items()}
    return Graph(graph.initial, graph.ids, leaving)


def _least(attempts: int, graph: Graph, name: str, entries: Bound) -> int:
    """Return how often a state with attempts runs at most."""
    return attempts if entries is None or name in graph.looping else min(attempts, entries)


def _reaching(
    starts: list[str], free: Graph, graph: Graph, attempts: Mapping[str, int]
) -> Mapping[str, int]:
    """Return the stretches that can come to each state, as a set with one bit per stretch."""
    reaching = dict.fromkeys(graph.ids, 0)
    steps = Steps(free)
    reaching[graph.initial] = 1
    for index, name in enumerate(starts[1:], start=1):
        for edge in graph.leaving.get(name, ()):
            if edge.event != EXHAUSTED and edge.target in reaching:
                reaching[edge.target] |= 1 << index
                steps.look_at(edge.target)
    for name in steps:
        for edge in free.leaving.get(name, ()):
            old = reaching.get(edge.target)
            if old is not None and reaching[name] & ~old:
                reaching[edge.target] = old | reaching[name]
                steps.look_at(edge.target)
    return reaching
