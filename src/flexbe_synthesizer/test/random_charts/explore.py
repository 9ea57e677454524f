"""All runs of a chart: which values can be missing when they are read, or be another state's.

And in which places a run cannot go on.

Every event of every state is possible, whatever the values are. What is written is followed in
cells: places that are one value since they feed one output of the chart. A cell knows who wrote it
last. A container that is left by a timeout, or since it is no longer waited for, may be anywhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from random_charts.chart_xml import CHART, Node, Place, Scope

MOST_STEPS = 20_000
MISROUTED = "written by another output"
UNROUTED = "not written with 'failed'"
Memory = frozenset[tuple[Place, str]]  # (cell, node that wrote it last)
Counts = frozenset[tuple[str, int]]
Run = tuple[str, Memory, Counts]  # where it is: about to enter a node, or at an outcome


class TooManyRunsError(Exception):
    """There are too many runs to follow."""


class Fault(NamedTuple):
    """What is wrong in some run: at which node, with which input, and what."""

    path: str
    key: str
    what: str


class End(NamedTuple):
    """How a node ends: event, outputs written by then, and counts; without event, in between."""

    event: str
    written: frozenset[str]
    counts: Counts


def explore(chart: Scope) -> tuple[Fault, ...]:
    """Return all that can go wrong with data in any run.

    Raises:
        TooManyRunsError: if there are too many to follow.
    """
    return tuple(sorted(_explored(chart, MOST_STEPS).faults))


def explore_all(chart: Scope, most_steps: int) -> tuple[Fault, ...]:
    """Return all that can go wrong in any run: with data, and places where it cannot go on.

    Raises:
        TooManyRunsError: if there are too many to follow.
    """
    explorer = _explored(chart, most_steps)
    return (*explorer.dead_ends, *sorted(explorer.faults))


def _explored(chart: Scope, most_steps: int) -> _Explorer:
    explorer = _Explorer(most_steps)
    explorer.ends(chart, "", frozenset())
    for path, behavior in _behaviors(chart, ""):  # whether a run comes there or not
        explorer.ends(behavior, path, frozenset())
    return explorer


def _behaviors(scope: Scope, path: str) -> Iterator[tuple[str, Scope]]:
    """Yield the charts of the behaviors in a chart."""
    for node in scope.nodes.values():
        if node.scope is not None:
            inside = f"{path}/{node.id}"
            if node.tag == "behavior":
                yield inside, node.scope
            yield from _behaviors(node.scope, inside)


class _Explorer:
    def __init__(self, most_steps: int) -> None:
        self._known: dict[tuple[str, Counts], frozenset[End]] = {}
        self._steps, self._most_steps = 0, most_steps
        self.faults: dict[Fault, None] = {}
        self.dead_ends: dict[Fault, None] = {}

    def ends(self, scope: Scope, path: str, counts: Counts) -> frozenset[End]:
        """Return all ways in which a visit can end, or can be cut short."""
        key = (path, counts)
        if key not in self._known:
            follow = self._sequential if scope.initial else self._simultaneous
            self._known[key] = frozenset(follow(scope, path, counts))
        return self._known[key]

    def _count_step(self) -> None:
        self._steps += 1
        if self._steps > self._most_steps:
            raise TooManyRunsError

    def _sequential(self, scope: Scope, path: str, counts: Counts) -> Iterator[End]:
        cells = _Cells(scope)
        waiting = [(scope.initial, cells.given(), counts)]
        after: dict[Run, list[Run]] = {waiting[0]: []}
        while waiting:
            self._count_step()
            run = target, memory, now = waiting.pop()
            written = cells.outputs(memory)
            yield End("" if target in scope.nodes else target, written, now)
            if target not in scope.nodes:
                continue
            node = scope.nodes[target]
            for end in self._visit(node, f"{path}/{target}", memory, now, cells=cells):
                reached = cells.after(node, end.written, memory)
                if end.event == "failed" and node.routes and "error_code" not in end.written:
                    self.faults[Fault(f"{path}/{target}", "error_code", UNROUTED)] = None
                if not end.event:
                    yield End("", cells.outputs(reached), end.counts)
                    continue
                if end.event not in node.events:
                    self.dead_ends[Fault(f"{path}/{target}", end.event, "leads nowhere")] = None
                for following in _targets(node, end.event):
                    place = (following, reached, end.counts)
                    after[run].append(place)
                    if place not in after:
                        after[place] = []
                        waiting.append(place)
        self._find_endless(after, scope, path)

    def _find_endless(self, after: Mapping[Run, list[Run]], scope: Scope, path: str) -> None:
        """Report the places from which no outcome can be reached."""
        before: dict[Run, list[Run]] = {run: [] for run in after}
        for run, following in after.items():
            for place in following:
                before[place].append(run)
        waiting = [run for run in after if run[0] in scope.outcomes]
        ending = set(waiting)
        while waiting:
            new = set(before[waiting.pop()]) - ending
            ending |= new
            waiting += new
        for run in after:
            if run not in ending:
                self.dead_ends[Fault(f"{path}/{run[0]}", "", "leads to no outcome")] = None

    def _visit(
        self, node: Node, path: str, memory: Memory, counts: Counts, cells: _Cells
    ) -> Iterator[End]:
        if node.attempts is not None:
            visits = min(dict(counts).get(path, 0), node.attempts) + 1
            counts = frozenset({**dict(counts), path: visits}.items())
            if visits > node.attempts:
                yield End("exhausted", frozenset(), counts)
                return
        for key in node.inputs:
            what = cells.complaint(node, key, memory)
            if what:
                self.faults[Fault(path, key, what)] = None
        if node.routes and cells.is_shared(node, "error_code"):
            self.faults[Fault(path, "error_code", MISROUTED)] = None
        if node.scope is None:
            for event in node.own:
                outputs = frozenset(node.kind.written(event, node.outputs))
                yield End(event, outputs, counts)
            if node.is_timed:
                yield End("timed_out", frozenset(), counts)
            return
        inside = frozenset() if node.tag == "behavior" else counts
        for end in self.ends(node.scope, path, inside):
            reached = counts if node.tag == "behavior" else end.counts
            yield end._replace(counts=reached)
            if node.is_timed and not end.event:
                yield End("timed_out", end.written, reached)

    def _simultaneous(self, scope: Scope, path: str, counts: Counts) -> Iterator[End]:
        cells = _Cells(scope)
        given = cells.given()
        for node in scope.nodes.values():
            for key in node.inputs:
                if cells.is_written_beside(node, key):
                    self.faults[Fault(f"{path}/{node.id}", key, "written at the same time")] = None
        ends = {
            node.id: set(self._visit(node, f"{path}/{node.id}", given, counts, cells=cells))
            for node in scope.nodes.values()
        }
        waiting: list[dict[str, End]] = [{}]
        seen: set[frozenset] = set()
        while waiting:
            self._count_step()
            done = waiting.pop()
            frozen = frozenset(done.items())
            if frozen in seen:
                continue
            seen.add(frozen)
            events = {name: end.event for name, end in done.items()}
            fulfilled = [o for o, all_of in scope.conditions if all_of.items() <= events.items()]
            yield from self._cut(scope, cells, done, ends, event=fulfilled[0] if fulfilled else "")
            if not fulfilled and len(done) == len(ends):
                each = ", ".join(f"{name} {event}" for name, event in sorted(events.items()))
                self.dead_ends[Fault(path, "", f"waits forever after {each}")] = None
            elif not fulfilled:
                for name in ends.keys() - done.keys():
                    waiting += ({**done, name: end} for end in ends[name] if end.event)

    def _cut(
        self,
        scope: Scope,
        cells: _Cells,
        done: Mapping[str, End],
        ends: Mapping[str, Iterable[End]],
        event: str,
    ) -> Iterator[End]:
        """Yield what is written when some have ended, and the others are anywhere."""
        partial: list[tuple[Memory, dict[str, int]]] = [(cells.given(), {})]
        for name, node in scope.nodes.items():
            possible = [done[name]] if name in done else [e for e in ends[name] if not e.event]
            following = {}
            for memory, visits in partial:
                for end in possible or [End("", frozenset(), frozenset())]:
                    self._count_step()
                    merged = dict(visits)
                    for path, count in end.counts:
                        merged[path] = max(count, merged.get(path, 0))
                    after = cells.after(node, end.written, memory)
                    following[after, frozenset(merged.items())] = (after, merged)
            partial = list(following.values())
        for memory, visits in partial:
            yield End(event, cells.outputs(memory), frozenset(visits.items()))


def _targets(node: Node, event: str) -> Iterator[str]:
    if event in node.events:
        yield node.events[event]
    if event == "failed":
        yield from (target for _codes, target in node.routes)


class _Cells:
    """The values of a chart or container."""

    def __init__(self, scope: Scope) -> None:
        self._scope = scope
        self._parent: dict[Place, Place] = {}
        for output in scope.outputs:
            places = sorted(scope.feeders(output))
            for place in places[1:]:
                self._parent[self._cell(place)] = self._cell(places[0])
        self._feeding = {
            output: frozenset(map(self._cell, scope.feeders(output))) for output in scope.outputs
        }

    def _cell(self, place: Place) -> Place:
        while place in self._parent and self._parent[place] != place:
            place = self._parent[place]
        return place

    def given(self) -> Memory:
        """Return what the caller has written."""
        return frozenset((self._cell((CHART, name)), CHART) for name in self._scope.inputs)

    def complaint(self, node: Node, key: str, memory: Memory) -> str:
        """Return what is wrong with a value that is read; empty if nothing is."""
        named = self._scope.source(node.id, key)
        if named is None:
            return "" if key in node.optional else "nothing feeds it"
        writer = dict(memory).get(self._cell(self._scope.place(*named)))
        if writer is None:
            return "not written"
        cell = self._cell(self._scope.place(*named))
        if node.scope is not None and any(o != key for o in self._outputs_in(node, cell)):
            return f"written while {node.id} reads it"
        if (node.id, key) not in self._scope.into or named[0] == CHART:
            return ""
        in_place = node.id if key in node.outputs else CHART
        if writer not in (named[0], in_place, CHART):
            return f"written by {writer}"
        shared = [o for o in self._outputs_in(self._scope.nodes[named[0]], cell) if o != named[1]]
        return f"written by output {shared[0]} of {named[0]}" if shared else ""

    def is_written_beside(self, node: Node, key: str) -> bool:
        """Return whether another node writes what this one reads."""
        named = self._scope.source(node.id, key)
        if named is None:
            return False
        cell = self._cell(self._scope.place(*named))
        nodes = self._scope.nodes.values()
        return any(self._outputs_in(other, cell) for other in nodes if other is not node)

    def is_shared(self, node: Node, output: str) -> bool:
        """Return whether another output of the node is the same value."""
        return len(self._outputs_in(node, self._cell(self._scope.place(node.id, output)))) > 1

    def _outputs_in(self, node: Node, cell: Place) -> list[str]:
        return [o for o in node.outputs if self._cell(self._scope.place(node.id, o)) == cell]

    def after(self, node: Node, written: Iterable[str], memory: Memory) -> Memory:
        """Return the memory after a node has written outputs."""
        if not written:
            return memory
        cells = {self._cell(self._scope.place(node.id, key)): node.id for key in written}
        return frozenset({**dict(memory), **cells}.items())

    def outputs(self, memory: Memory) -> frozenset[str]:
        """Return the outputs of the chart that its nodes have written."""
        cells = {cell for cell, writer in memory if writer != CHART}
        return frozenset(name for name, feeding in self._feeding.items() if feeding & cells)
