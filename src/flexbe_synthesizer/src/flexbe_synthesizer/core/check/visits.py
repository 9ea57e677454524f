"""How often the states of a chart or container can be visited in one run, at most.

A run is cut into stretches at each visit to a state with `ext:attempts`. Within a stretch a state
is visited once, or nothing bounds it; so its visits are bounded by the stretches that can come to
it. The bound may be larger than what a run can reach, never smaller.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexbe_synthesizer.core.chart.names import EXHAUSTED
from flexbe_synthesizer.core.library.definite_assignment import Steps
from flexbe_synthesizer.core.library.graph import Graph
from flexbe_synthesizer.core.library.resolve import ResolvedChart

Bound = int | None  # None: nothing bounds it


def most_visits(resolved: ResolvedChart, entries: Bound) -> Mapping[str, Bound]:
    """Return how often each state of a chart or container runs at most; `entries`: how often it."""
    if resolved.is_concurrent:
        return dict.fromkeys(resolved.by_id, entries)
    graph = resolved.graph
    looping, unbounded = graph.looping, graph.free.looping.difference(graph.counted)
    attempts = {name: resolved.by_id[name].node.attempts for name in graph.counted}
    for name in attempts.keys() - looping:
        attempts[name] = _lesser(attempts[name], entries)
    weights = [entries, *attempts.values()]  # of the stretches, by bit
    totals: dict[int, Bound] = {0: 0}
    visits: dict[str, Bound] = {}
    for name, mask in _reaching(graph).items():
        if mask not in totals:
            totals[mask] = _total(weights, mask)
        most = None if mask and name in unbounded else totals[mask]
        if name not in looping:
            most = _lesser(most, entries)
        visits[name] = _lesser(most, attempts[name]) if name in attempts else most
    return visits


def _lesser(one: Bound, other: Bound) -> Bound:
    """Return the closer of two bounds."""
    if one is None or other is None:
        return other if one is None else one
    return min(one, other)


def _total(weights: Sequence[Bound], mask: int) -> Bound:
    """Return the sum of the weights of a set of stretches."""
    total = 0
    while mask:
        last = mask.bit_length() - 1
        weight = weights[last]
        if weight is None:
            return None
        total += weight
        mask ^= 1 << last
    return total


def _reaching(graph: Graph) -> Mapping[str, int]:
    """Return the stretches that can come to each state, as a set with one bit per stretch.

    The first begins with the chart or container, each other one where a counted state leads.
    """
    free = graph.free
    reaching = dict.fromkeys(graph.ids, 0)
    steps = Steps(free)
    reaching[graph.initial] = 1
    for index, name in enumerate(graph.counted, start=1):
        begun = 1 << index
        for edge in graph.leaving.get(name, ()):
            if edge.event != EXHAUSTED and edge.target in reaching:
                reaching[edge.target] |= begun
                steps.visit(edge.target)
    for name in steps:
        mask = reaching[name]
        for edge in free.leaving.get(name, ()):
            old = reaching.get(edge.target)
            if old is not None and old | mask != old:
                reaching[edge.target] = old | mask
                steps.visit(edge.target)
    return reaching
