"""Which values are certainly written when a state is entered, or when a container ends.

A forward analysis over sets of homes, each set one integer with a bit per home. A state writes all
its outputs when it ends with an outcome of its own; a container writes with an outcome what every
path to that outcome inside it writes. Leaving by `timed_out` of a timer writes nothing. The event
`exhausted` happens on a later entry only, so it leaves with what all entries out of a loop through
the state bring, and with what the state itself has written on its way round.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from functools import reduce
from operator import and_

from flexbe_synthesizer.core.data_flow import DataFlow, Key, bind_data
from flexbe_synthesizer.core.graph import Edge, Graph, chart_graph, condition_edges
from flexbe_synthesizer.core.resolve import ResolvedChart


class Values:
    """Who writes which home of a chart or container, and on which edges."""

    def __init__(self, resolved: ResolvedChart, flow: DataFlow, graph: Graph) -> None:
        """Sort the outputs by home, and by edge."""
        self.graph = graph
        self.writers: dict[str, list[str]] = {}
        self._homes: dict[str, frozenset[str]] = {}
        own: dict[str, set[str]] = {}
        for key, home in flow.outputs.items():
            own.setdefault(key.node, set()).add(home)
            self.writers.setdefault(home, []).append(key.node)
        self._homes = {node: frozenset(homes) for node, homes in own.items()}
        self._bodies = {
            node: {
                event: frozenset(flow.outputs[Key(node, name)] for name in written)
                for event, written in certain_outputs(entry.body).items()
            }
            for node, entry in resolved.by_id.items()
            if entry.body is not None
        }
        self._bits = {home: 1 << index for index, home in enumerate(self.writers)}

    def homes(self, edge: Edge) -> frozenset[str]:
        """Return the homes that are certainly written when an edge is taken."""
        if not edge.executed:
            return frozenset()
        if edge.source in self._bodies:
            return self._bodies[edge.source].get(edge.event, frozenset())
        return self._homes.get(edge.source, frozenset())

    def has(self, written: int, home: str) -> bool:
        """Tell whether a home is in a set."""
        return bool(written & self._bits[home])

    def edges_not_writing(self, home: str) -> dict[str, tuple[Edge, ...]]:
        """Return the edges from each state that are taken without writing the home."""
        silent = dict(self.graph.leaving)
        for node in self.writers[home]:
            silent[node] = tuple(e for e in silent.get(node, ()) if home not in self.homes(e))
        return silent

    def written_before(self, given: Iterable[str]) -> Mapping[str, int]:
        """Return, for each state and outcome that can be reached, the homes written by then."""
        graph, writes = self.graph, {edge: self._set(self.homes(edge)) for edge in self.graph.edges}
        before: dict[str, int] = {graph.initial: self._set(given)}
        spent: dict[str, int] = {}  # the homes written when a counted state is left exhausted

        def after(edge: Edge) -> int | None:
            """Return the homes written when the edge is taken, None if it is not known to be."""
            return (
                spent.get(edge.source) if edge.is_exhausted else before[edge.source] | writes[edge]
            )

        def narrow(homes: dict[str, int], name: str, arriving: int) -> bool:
            """Keep what arrives on every edge; tell whether that changed anything."""
            old = homes.get(name)
            homes[name] = arriving if old is None else old & arriving
            return homes[name] != old

        waiting = deque([graph.initial])
        while waiting:
            for edge in graph.leaving.get(waiting.popleft(), ()):
                arriving = after(edge)
                if arriving is None:
                    continue
                has_changed = narrow(before, edge.target, arriving)
                if graph.loops.get(edge.target) == graph.loops[edge.source]:
                    round_trip = self._written_on_way_round(edge.target, writes)
                    has_changed |= narrow(spent, edge.target, arriving | round_trip)
                if has_changed:
                    waiting.append(edge.target)
        return before

    def _set(self, homes: Iterable[str]) -> int:
        return sum(self._bits.get(home, 0) for home in homes)

    def _written_on_way_round(self, name: str, writes: Mapping[Edge, int]) -> int:
        """Return what a state that comes back to itself has written, whichever way it left."""
        ways = [
            writes[edge]
            for edge in self.graph.leaving.get(name, ())
            if not edge.is_exhausted and self.graph.loops.get(edge.target) == self.graph.loops[name]
        ]
        return reduce(and_, ways or [0])


def certain_outputs(resolved: ResolvedChart) -> Mapping[str, frozenset[str]]:
    """Return, for each outcome of a container, its outputs that are then certainly written."""
    flow, graph = bind_data(resolved), chart_graph(resolved)
    values = Values(resolved, flow, graph)
    given = {port.name for port in resolved.chart.inputs}
    outputs = [port.name for port in resolved.chart.outputs]
    outcomes = [outcome.name for outcome in resolved.chart.outcomes]
    if resolved.is_concurrent:
        causes: dict[str, frozenset[str]] = {}
        for condition in resolved.chart.conditions:
            edges = condition_edges(condition, resolved)
            written = frozenset(given).union(*map(values.homes, edges))
            causes[condition.outcome] = causes.get(condition.outcome, written) & written
        return {o: frozenset(outputs) & causes.get(o, frozenset()) for o in outcomes}
    before = values.written_before(given)
    return {
        outcome: frozenset(
            name
            for name in outputs
            if name in given
            or (outcome in before and name in values.writers and values.has(before[outcome], name))
        )
        for outcome in outcomes
    }
