"""The chart as a graph: what leads where, which values are written on the way."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.model import AnyNode, Chart, Condition
from flexbe_synthesizer.core.resolve import EXHAUSTED, FAILED, ResolvedChart

_STEPS_SHOWN = 10  # of a path, at its beginning and at its end


class Edge(NamedTuple):
    """A transition.

    Attributes:
        executed: the source certainly ran to an outcome of its own.
        is_exhausted: it is taken only on a later entry, instead of running the source again. Where
            attempts may be spent before the first entry, it is an edge like any other.
    """

    source: str
    event: str
    target: str
    executed: bool = True
    is_exhausted: bool = False


@dataclass(frozen=True)
class Graph:
    """States and behaviors by id, and the edges from them; targets may be outcomes."""

    initial: str
    ids: tuple[str, ...]
    edges: tuple[Edge, ...]

    @cached_property
    def leaving(self) -> Mapping[str, Sequence[Edge]]:
        """Return the edges from each state."""
        return _grouped((edge.source, edge) for edge in self.edges)

    @cached_property
    def entering(self) -> Mapping[str, Sequence[Edge]]:
        """Return the edges to each state or outcome."""
        return _grouped((edge.target, edge) for edge in self.edges)

    @property
    def order(self) -> tuple[str, ...]:
        """Return the states so that each stands before all that only it leads to."""
        return self._search[0]

    @property
    def reached(self) -> frozenset[str]:
        """Return the states that the initial one leads to, itself included."""
        return self._search[1]

    @cached_property
    def _search(self) -> tuple[tuple[str, ...], frozenset[str]]:
        """Return the reverse order in which a search in depth leaves the states, and `reached`."""
        reached: frozenset[str] = frozenset()
        leaving = self.leaving
        unseen = set(self.ids)
        left: list[str] = []
        for start in self.ids:
            if start not in unseen:
                continue
            unseen.discard(start)
            trail = [(start, iter(leaving.get(start, ())))]
            while trail:
                name, edges = trail[-1]
                for edge in edges:
                    if edge.target in unseen:
                        unseen.discard(edge.target)
                        trail.append((edge.target, iter(leaving.get(edge.target, ()))))
                        break
                else:
                    left.append(name)
                    trail.pop()
            if start == self.initial:
                reached = frozenset(left)
        return tuple(reversed(left)), reached

    @cached_property
    def loops(self) -> Mapping[str, int]:
        """Return a number per state, equal for states that can reach each other (Kosaraju)."""
        entering = self.entering
        unseen = set(self.ids)
        component: dict[str, int] = {}
        for number, start in enumerate(self.order):
            if start not in unseen:
                continue
            unseen.discard(start)
            waiting = [start]
            while waiting:
                name = waiting.pop()
                component[name] = number
                for edge in entering.get(name, ()):
                    if edge.source in unseen:
                        unseen.discard(edge.source)
                        waiting.append(edge.source)
        return component

    @cached_property
    def looping(self) -> frozenset[str]:
        """Return the states that can come back to themselves."""
        loops = self.loops
        return frozenset(
            edge.source for edge in self.edges if loops[edge.source] == loops.get(edge.target)
        )


def chart_graph(resolved: ResolvedChart) -> Graph:
    """Return the graph of a chart, or of the content of a container.

    A misspelt target or initial state stands for the name that was meant, so that one mistake is
    not reported a second time as an unreachable state. What is in a concurrency container has no
    order: its edges are the events that its conditions wait for, and lead to its outcomes.
    """
    chart, ids, is_repeated = resolved.chart, tuple(resolved.by_id), resolved.is_repeated
    known = set(resolved.targets)
    if resolved.is_concurrent:
        conditions = chart.conditions
        return Graph("", ids, tuple(e for c in conditions for e in condition_edges(c, resolved)))

    edges: list[Edge] = []
    for source, entry in resolved.by_id.items():
        added = entry.use.added_events
        counted = entry.node.attempts is not None and not entry.use.has_own(EXHAUSTED)
        for event, target in _leads(entry.node):
            if target not in known:
                target = names.misspelt(target, resolved.targets) or target
            is_exhausted = counted and event == EXHAUSTED and not is_repeated
            edges.append(Edge(source, event, target, event not in added, is_exhausted))
    initial = chart.initial
    if initial not in resolved.by_id:
        initial = names.misspelt(initial, resolved.ids) or initial
    return Graph(initial, tuple(sorted(ids, key=lambda name: name != initial)), tuple(edges))


def looping_nodes(chart: Chart) -> frozenset[str]:
    """Return the nodes of a chart, or of the content of a container, that can be entered again."""
    ids = tuple(dict.fromkeys(node.id for node in chart.nodes))
    edges = (Edge(node.id, *lead) for node in chart.nodes for lead in _leads(node))
    return Graph(chart.initial, ids, tuple(edges)).looping


def _leads(node: AnyNode) -> list[tuple[str, str]]:
    """Return event and target of each way out of a node."""
    leads = [(transition.event, transition.target) for transition in node.transitions]
    leads.extend((FAILED, route.target) for route in node.on_error)
    return leads


def condition_edges(condition: Condition, resolved: ResolvedChart) -> Iterator[Edge]:
    """Yield the events that a condition of a concurrency container waits for, as edges."""
    for when in condition.all_of:
        entry = resolved.by_id.get(when.state)
        if entry is not None:
            executed = when.event not in entry.use.added_events
            yield Edge(when.state, when.event, condition.outcome, executed)


def reachable(starts: Iterable[str], successors: Callable[[str], Iterable[str]]) -> set[str]:
    """Return what can be reached from the starts, they included."""
    found = set(starts)
    waiting = list(found)
    while waiting:
        for name in successors(waiting.pop()):
            if name not in found:
                found.add(name)
                waiting.append(name)
    return found


def shortest_path(
    start: str, goal: str, leaving: Mapping[str, Iterable[Edge]]
) -> tuple[Edge, ...] | None:
    """Return the fewest edges, at least one, that lead from start to goal; None if none do."""
    came: dict[str, Edge] = {}
    waiting = deque([start])
    while waiting and goal not in came:
        for edge in leaving.get(waiting.popleft(), ()):
            if edge.target not in came:
                came[edge.target] = edge
                waiting.append(edge.target)
    if goal not in came:
        return None
    path = [came[goal]]
    while path[-1].source != start:
        path.append(came[path[-1].source])
    return tuple(reversed(path))


def path_text(path: tuple[Edge, ...]) -> str:
    """Return the path as `A -failed-> B -done-> C`, of a long one the beginning and the end."""
    if not path:
        return "on some path"
    steps = [f" -{edge.event}-> {edge.target}" for edge in path]
    if len(steps) > 2 * _STEPS_SHOWN:
        left_out = f" ... {len(steps) - 2 * _STEPS_SHOWN} more ..."
        steps = [*steps[:_STEPS_SHOWN], left_out, *steps[-_STEPS_SHOWN:]]
    return path[0].source + "".join(steps)


def _grouped(named: Iterable[tuple[str, Edge]]) -> Mapping[str, list[Edge]]:
    """Return the edges that have one name, by that name."""
    groups: dict[str, list[Edge]] = defaultdict(list)
    for name, edge in named:
        groups[name].append(edge)
    return dict(groups)
