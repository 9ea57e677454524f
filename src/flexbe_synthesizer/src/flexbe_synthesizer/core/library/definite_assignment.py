"""Definite assignment: the values certainly written when a state is entered, or by an outcome.

A forward analysis over sets of homes, each set one integer with a bit per home. What a state,
behavior or container writes depends on the outcome that it ends with, see `signature.Effect`; this
is also where a chart's own effects come from. Leaving by `timed_out` of a timer writes nothing for
certain. The event `exhausted` happens on a later entry only, so it leaves with what all entries out
of a loop through the state bring, and with what the state itself has written on its way round.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, reduce
from heapq import heappop, heappush
from operator import and_, or_

from flexbe_synthesizer.core.chart.model import State
from flexbe_synthesizer.core.chart.names import EXHAUSTED
from flexbe_synthesizer.core.library.data_flow import DataFlow, Scope
from flexbe_synthesizer.core.library.graph import Edge, Graph, condition_edges
from flexbe_synthesizer.core.library.signature import Effect


class Values:
    """Who writes which home of a chart or container, and on which edges.

    Only homes that are outputs, or that an input reads, are distinguished.
    """

    def __init__(self, scope: Scope, flow: DataFlow, graph: Graph) -> None:
        self.graph = graph
        self._by_id = scope.by_id
        known = flow.read | {port.name for port in scope.chart.outputs}
        self.writers: dict[str, list[str]] = {}
        self._bits: dict[str, int] = {}
        self._own: dict[str, int] = {}
        for node, homes in flow.outputs.items():
            own = 0
            for home in homes.values():
                if home not in known:
                    continue
                if home in self.writers:
                    self.writers[home].append(node)
                else:
                    self.writers[home] = [node]
                    self._bits[home] = 1 << len(self._bits)
                own |= self._bits[home]
            if own:
                self._own[node] = own
        self._limited: dict[str, dict[str, tuple[int, int]]] = {}
        for node in self._own:
            signature = scope.by_id[node].use.signature
            if signature is not None and signature.effects:
                homes = flow.outputs[node]
                self._limited[node] = {
                    effect.outcome: (
                        self._set(homes, effect.certain),
                        self._set(homes, effect.possible),
                    )
                    for effect in signature.effects
                }

    def _set(self, homes: Mapping[str, str], written: Collection[str]) -> int:
        """Return the homes of some outputs of a node."""
        return reduce(or_, (self._bits.get(homes[n], 0) for n in written if n in homes), 0)

    def written_on(self, edge: Edge) -> int:
        """Return the homes that are certainly written when an edge is taken."""
        if not edge.executed:
            return 0
        own = self._own.get(edge.source, 0)
        if edge.source not in self._limited:
            return own
        return self._limited[edge.source].get(edge.event, (own, own))[0]

    def touched_on(self, edge: Edge) -> int:
        """Return the homes that may be written when an edge is taken.

        A state that a timer ends has written nothing; a behavior or container has run for a while.
        """
        if edge.executed:
            own, limited = self._own.get(edge.source, 0), self._limited.get(edge.source)
            return own if limited is None else limited.get(edge.event, (own, own))[1]
        entry = self._by_id[edge.source]
        is_cut = edge.event != EXHAUSTED and not isinstance(entry.node, State)
        return self.touched_in(edge.source) if is_cut or entry.use.has_own(edge.event) else 0

    def touched_in(self, node: str) -> int:
        """Return the homes that may be written while a node runs, whatever it ends with."""
        own, limited = self._own.get(node, 0), self._limited.get(node)
        signature = self._by_id[node].use.signature
        if limited is None or signature is None:
            return own
        outcomes = signature.outcomes or ()
        return reduce(or_, (limited.get(outcome, (own, own))[1] for outcome in outcomes), 0)

    def has(self, written: int, home: str) -> bool:
        """Return whether a home is in a set."""
        return bool(written & self._bits[home])

    def edges_not_writing(self, home: str) -> dict[str, Sequence[Edge]]:
        """Return the edges from each state that are taken without writing the home."""
        silent = dict(self.graph.leaving)
        for node in self.writers[home]:
            edges = silent.get(node, ())
            silent[node] = tuple(e for e in edges if not self.has(self.written_on(e), home))
        return silent

    @cached_property
    def last_writers(self) -> LastWriters:
        """Return which states can have written a home last."""
        return LastWriters(self)

    @cached_property
    def written_before(self) -> Mapping[str, int]:
        """Return, for each state and outcome that can be reached, the homes written by then.

        States are visited again in the order of the graph, until a fixed point.
        """
        graph, loops = self.graph, self.graph.loops
        leaving = graph.leaving
        counted = {edge.source for edge in graph.edges if edge.is_exhausted}
        before: dict[str, int] = {graph.initial: 0}
        spent: dict[str, int] = {}  # the homes written when a counted state is left exhausted
        round_trips: dict[str, int] = {}
        steps = Steps(graph)
        for name in steps:
            written = before[name]
            for edge in leaving.get(name, ()):
                target = edge.target
                if not edge.is_exhausted:
                    arriving = written | self.written_on(edge)
                elif name in spent:
                    arriving = spent[name]
                else:
                    continue  # no way round to it is known yet
                old = before.get(target)
                before[target] = new = arriving if old is None else old & arriving
                has_changed = new != old
                if target in counted and loops[target] == loops[name]:
                    if target not in round_trips:
                        round_trips[target] = self._written_on_way_round(target)
                    has_changed |= _narrow(spent, target, arriving | round_trips[target])
                if has_changed:
                    steps.visit(target)
        return before

    def touched_before(self, homes: Iterable[str]) -> Mapping[str, int]:
        """Return, for each state and outcome that can be reached, what may be written by then.

        Args:
            homes: the only ones that are distinguished.
        """
        among = reduce(or_, (self._bits[home] for home in homes), 0)
        before: dict[str, int] = {self.graph.initial: 0}
        waiting = [self.graph.initial]
        while waiting:
            name = waiting.pop()
            for edge in self.graph.leaving.get(name, ()):
                arriving = before[name] | self.touched_on(edge) & among
                old = before.get(edge.target)
                if old is None or arriving & ~old:
                    before[edge.target] = arriving | (old or 0)
                    waiting.append(edge.target)
        return before

    def _written_on_way_round(self, name: str) -> int:
        """Return what a state has written whenever it is entered again, whichever event left it."""
        loops = self.graph.loops
        ways = [
            self.written_on(edge)
            for edge in self.graph.leaving.get(name, ())
            if not edge.is_exhausted and loops.get(edge.target) == loops[name]
        ]
        return reduce(and_, ways or [0])


class LastWriters:
    """Which states can have written a home last when a state is entered.

    A forward analysis, too, over sets of (state, home), each set one integer; only homes with more
    than one writer are distinguished.
    """

    def __init__(self, values: Values) -> None:
        self._values = values
        self._shared: dict[str, list[str]] = {}
        self._bits: dict[tuple[str, str], int] = {}
        self._all: dict[str, int] = {}
        for home, nodes in values.writers.items():
            if len(nodes) == 1:
                continue
            for node in nodes:
                self._shared.setdefault(node, []).append(home)
                self._bits[node, home] = 1 << len(self._bits)
                self._all[home] = self._all.get(home, 0) | self._bits[node, home]

    def besides(self, expected: Collection[str], home: str, reader: str) -> str | None:
        """Return a state other than those expected that can have written the home that is read.

        The home is one that several states write.
        """
        before = self._before.get(reader, 0)
        for node in self._values.writers[home]:
            if node not in expected and before & self._bits[node, home]:
                return node
        return None

    @cached_property
    def _before(self) -> Mapping[str, int]:
        """Return the states that can have written last, for each state."""
        graph = self._values.graph
        before: dict[str, int] = {graph.initial: 0}
        steps = Steps(graph)
        for name in steps:
            for edge in graph.leaving.get(name, ()):
                arriving = self._after(edge, before[name])
                old = before.get(edge.target)
                before[edge.target] = arriving if old is None else old | arriving
                if before[edge.target] != old:
                    steps.visit(edge.target)
        return before

    def _after(self, edge: Edge, before: int) -> int:
        shared = self._shared.get(edge.source)
        if shared is None:
            return before
        written, touched = self._values.written_on(edge), self._values.touched_on(edge)
        for home in shared:
            if self._values.has(written, home):
                before &= ~self._all[home]
            if self._values.has(touched, home):
                before |= self._bits[edge.source, home]
        return before


class Steps:
    """The states of a graph that are still to be visited, in the graph's order."""

    def __init__(self, graph: Graph) -> None:
        self._order = graph.order
        self._rank = graph.rank
        self._waiting: list[int] = []
        self._is_waiting: set[str] = set()
        self.visit(graph.initial)

    def visit(self, name: str) -> None:
        """Have a state visited again; an outcome needs no visit."""
        if name in self._rank and name not in self._is_waiting:
            self._is_waiting.add(name)
            heappush(self._waiting, self._rank[name])

    def __iter__(self) -> Iterator[str]:
        while self._waiting:
            name = self._order[heappop(self._waiting)]
            self._is_waiting.discard(name)
            yield name


def _narrow(homes: dict[str, int], name: str, arriving: int) -> bool:
    """Keep what arrives on every edge; return whether that changed anything."""
    old = homes.get(name)
    homes[name] = new = arriving if old is None else old & arriving
    return new != old


def outcome_effects(scope: Scope, outputs: frozenset[str], values: Values) -> tuple[Effect, ...]:
    """Return which of its outputs each outcome of a chart, or of a container's content, writes.

    An outcome that nothing leads to never happens, so that nothing is left out with it.
    """
    known = outputs & values.writers.keys()
    if scope.is_concurrent:
        certain = _written_by_conditions(scope, values)
        everything = reduce(or_, map(values.touched_in, scope.by_id), 0)
        possible: Mapping[str, int] = dict.fromkeys(certain, everything)
    else:
        certain, possible = values.written_before, values.touched_before(known)
    return tuple(
        Effect(
            name,
            frozenset(home for home in known if values.has(certain[name], home)),
            frozenset(home for home in known if values.has(possible[name], home)),
        )
        if name in certain
        else Effect(name, outputs, frozenset())
        for name in dict.fromkeys(outcome.name for outcome in scope.chart.outcomes)
    )


def _written_by_conditions(scope: Scope, values: Values) -> Mapping[str, int]:
    """Return the homes written with each outcome of a concurrency container."""
    causes: dict[str, int] = {}
    for condition in scope.chart.conditions:
        written = (values.written_on(edge) for edge in condition_edges(condition, scope))
        _narrow(causes, condition.outcome, reduce(or_, written, 0))
    return causes
