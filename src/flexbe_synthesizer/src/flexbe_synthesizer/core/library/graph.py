"""The chart as a graph: what leads where, which values are written on the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import AnyNode, Chart, Condition
from flexbe_synthesizer.core.chart.names import EXHAUSTED, FAILED
from flexbe_synthesizer.core.library.data_flow import Scope

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
    """States and behaviors by id, and the edges from each; targets may be outcomes.

    Attributes:
        counted: the states with `ext:attempts`.
    """

    initial: str
    ids: tuple[str, ...]
    leaving: Mapping[str, Sequence[Edge]]
    counted: Collection[str] = ()

    @property
    def edges(self) -> Iterator[Edge]:
        """Return all edges."""
        return chain.from_iterable(self.leaving.values())

    @cached_property
    def entering(self) -> Mapping[str, Sequence[Edge]]:
        """Return the edges to each state or outcome."""
        groups: dict[str, list[Edge]] = {}
        for edges in self.leaving.values():
            for edge in edges:
                if edge.target in groups:
                    groups[edge.target].append(edge)
                else:
                    groups[edge.target] = [edge]
        return groups

    @property
    def order(self) -> tuple[str, ...]:
        """Return the states so that each stands before all that only it leads to."""
        return self._search[0]

    @cached_property
    def rank(self) -> Mapping[str, int]:
        """Return the place of each state in the order."""
        return {name: index for index, name in enumerate(self.order)}

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
                    target = edge.target
                    if target in unseen:
                        unseen.discard(target)
                        trail.append((target, iter(leaving.get(target, ()))))
                        break
                else:
                    left.append(name)
                    trail.pop()
            if start == self.initial:
                reached = frozenset(left)
        left.reverse()
        return tuple(left), reached

    @cached_property
    def loops(self) -> Mapping[str, int]:
        """Return a number per state, equal for states that can reach each other (Kosaraju)."""
        entering = self.entering
        component: dict[str, int] = {}
        for number, start in enumerate(self.order):
            if start in component:
                continue
            component[start] = number
            waiting = [start]
            while waiting:
                for edge in entering.get(waiting.pop(), ()):
                    if edge.source not in component:
                        component[edge.source] = number
                        waiting.append(edge.source)
        return component

    @cached_property
    def looping(self) -> frozenset[str]:
        """Return the states that can lead to themselves."""
        loops = self.loops
        found = set()
        for source, edges in self.leaving.items():
            number = loops[source]
            for edge in edges:
                if loops.get(edge.target) == number:
                    found.add(source)
                    break
        return frozenset(found)

    @cached_property
    def free(self) -> Graph:
        """Return the graph without what states with `ext:attempts` lead to when they run."""
        leaving = dict(self.leaving)
        for name in self.counted:
            leaving[name] = [e for e in leaving.get(name, ()) if e.event == EXHAUSTED]
        return Graph(self.initial, self.ids, leaving)


def chart_graph(scope: Scope) -> Graph:
    """Return the graph of a chart, or of the content of a container.

    A misspelt target or initial state stands for the name that was meant, so that one mistake is
    not reported a second time as an unreachable state. What is in a concurrency container has no
    order: its edges are the events that its conditions wait for, and lead to its outcomes.
    """
    chart, ids = scope.chart, tuple(scope.by_id)
    leaving: dict[str, list[Edge]] = {}
    counted = [name for name, entry in scope.by_id.items() if entry.node.attempts is not None]
    if scope.is_concurrent:
        for condition in chart.conditions:
            for edge in condition_edges(condition, scope):
                leaving.setdefault(edge.source, []).append(edge)
        return Graph("", ids, leaving, counted)

    known = set(scope.targets)
    for source, entry in scope.by_id.items():
        node, added = entry.node, entry.use.added_events
        is_last = node.attempts is not None and not entry.use.has_own(EXHAUSTED)
        is_last = is_last and not scope.is_repeated
        edges = [
            Edge(
                source,
                event,
                target,
                executed=event not in added,
                is_exhausted=is_last and event == EXHAUSTED,
            )
            for event, target in _leads(node)
        ]
        if edges:
            leaving[source] = edges
            if not all([edge.target in known for edge in edges]):
                leaving[source] = [
                    edge if edge.target in known else _mended(edge, scope) for edge in edges
                ]
    initial = chart.initial
    if initial not in scope.by_id:
        initial = names.misspelt(initial, scope.ids) or initial
    ordered = tuple(sorted(ids, key=lambda name: name != initial))
    return Graph(initial, ordered, leaving, counted)


def _mended(edge: Edge, scope: Scope) -> Edge:
    """Return an edge that leads to the target that was meant."""
    return edge._replace(target=names.misspelt(edge.target, scope.targets) or edge.target)


def looping_nodes(chart: Chart) -> frozenset[str]:
    """Return the nodes of a chart, or of the content of a container, that can be entered again."""
    leaving: dict[str, list[Edge]] = {}
    for node in chart.nodes:
        leaving.setdefault(node.id, []).extend(Edge(node.id, *lead) for lead in _leads(node))
    return Graph(chart.initial, tuple(leaving), leaving).looping


def _leads(node: AnyNode) -> list[tuple[str, str]]:
    """Return event and target of each way out of a node."""
    leads = [(transition.event, transition.target) for transition in node.transitions]
    leads.extend([(FAILED, route.target) for route in node.on_error])
    return leads


def condition_edges(condition: Condition, scope: Scope) -> Iterator[Edge]:
    """Yield the events that a condition of a concurrency container waits for, as edges."""
    for when in condition.all_of:
        entry = scope.by_id.get(when.state)
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
