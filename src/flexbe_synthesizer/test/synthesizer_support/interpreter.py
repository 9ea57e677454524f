"""Run a chart by the meaning of its language: the reference that everything else is held to.

`explore` follows every run of a chart, with every event of every state, and reports faults;
`chart_run` follows one. Nothing is shared with the checker or the expansion but the chart and what
its states offer, so that a mistake in one of them shows. This is written to be obviously right,
not fast: it takes charts of a few dozen states.

A visit to a state: with `attempts`, the visit is counted, and one too many gives `exhausted`.
Otherwise the inputs are read, and the state ends with an event of its own and writes its outputs,
or with `timed_out` and writes nothing. `failed` may go where `on_error` says. A container is run
inside; its outputs are what its states have written by then, also if it is cut short. In a
concurrency container each state is visited once, in any order, until a condition holds.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from flexbe_synthesizer.core.chart.model import AnyNode, Chart, Condition, Container

_CHART = ""  # the chart itself, among the ids of its nodes
MOST_PLACES = 200_000  # of a chart that is explored


class TooManyRunsError(RuntimeError):
    """A chart has more places than can be explored."""


class Interface(NamedTuple):
    """What a state or behavior offers: events, inputs that must be fed, outputs.

    Each event writes all outputs. `own_time` is set if it keeps a timeout itself.
    """

    events: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    own_time: bool = False


Interfaces = Callable[[AnyNode], Interface]
Memory = frozenset[tuple[Hashable, str]]  # (value, who wrote it)
Counts = frozenset[tuple[str, int]]  # (path, visits)


class End(NamedTuple):
    """How a node or chart ended: event, outputs written, and the counts by then."""

    event: str
    written: frozenset[str]
    counts: Counts


class Place(NamedTuple):
    """Where a run can be: a node about to be entered, or an outcome of the chart."""

    target: str
    memory: Memory
    counts: Counts


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong in a run: where, and what."""

    path: str
    what: str


def explore(chart: Chart, interfaces: Interfaces) -> tuple[Fault, ...]:
    """Return all that can go wrong in any run of a chart; nothing is good.

    Raises:
        TooManyRunsError: if there are too many runs to follow.
    """
    explorer = _Explorer(interfaces)
    explorer.ends(chart, "", frozenset())
    return tuple(dict.fromkeys(explorer.faults))


class _Explorer:
    """Follows all runs."""

    def __init__(self, interfaces: Interfaces) -> None:
        self._interfaces = interfaces
        self._known: dict[tuple[str, Counts], frozenset[End]] = {}
        self.faults: list[Fault] = []

    def ends(self, chart: Chart, path: str, counts: Counts) -> frozenset[End]:
        """Return all ways in which a chart, or the body of a container, can end."""
        key = (path, counts)
        if key not in self._known:
            self._known[key] = frozenset(
                self._simultaneous(chart, path, counts)
                if is_concurrent(chart)
                else self._sequential(chart, path, counts)
            )
        return self._known[key]

    def _sequential(self, chart: Chart, path: str, counts: Counts) -> Iterator[End]:
        values = _Values(chart, self._interfaces)
        nodes = {node.id: node for node in chart.nodes}
        outcomes = {outcome.name for outcome in chart.outcomes}
        start = Place(chart.initial, values.given(), counts)
        after: dict[Place, set[Place]] = {}
        waiting = [start]
        while waiting:
            place = waiting.pop()
            if place in after:
                continue
            if len(after) > MOST_PLACES:
                raise TooManyRunsError(path)
            after[place] = set()
            if place.target in outcomes:
                yield End(place.target, values.outputs(place.memory), place.counts)
            elif place.target not in nodes:
                self.faults.append(Fault(f"{path}/{place.target}", "does not exist"))
            else:
                after[place] = set(self._step(nodes[place.target], place, path, values))
                waiting.extend(after[place])
        self._find_endless(after, outcomes, path)

    def _step(self, node: AnyNode, place: Place, path: str, values: _Values) -> Iterator[Place]:
        """Yield where a run can go on after a node."""
        here = f"{path}/{node.id}"
        for end in self._visit(node, place, here, values):
            memory = values.written(node, end.written, place.memory)
            targets = [t.target for t in node.transitions if t.event == end.event]
            if len(targets) != 1:
                self.faults.append(Fault(here, f"'{end.event}' leads to {len(targets)} places"))
            if end.event == "failed":
                targets += [route.target for route in node.on_error]
            for target in targets:
                yield Place(target, memory, end.counts)

    def _visit(self, node: AnyNode, place: Place, here: str, values: _Values) -> Iterator[End]:
        """Yield all ways in which one visit to a node can end."""
        counts = place.counts
        if node.attempts is not None:
            visits = min(dict(counts).get(here, 0), node.attempts) + 1
            counts = frozenset({**dict(counts), here: visits}.items())
            if visits > node.attempts:
                yield End("exhausted", frozenset(), counts)
                return
        for complaint in values.complaints(node, place.memory):
            self.faults.append(Fault(here, complaint))
        if isinstance(node, Container):
            ends = self.ends(node.body, here, counts)
            yield from ends
            if node.timeout_s is not None:
                # The visit may be cut short anywhere; what it has counted by then is the least.
                for reached in {end.counts for end in ends} | {counts}:
                    yield End("timed_out", frozenset(), reached)
                for end in ends:
                    yield End("timed_out", end.written, end.counts)
            return
        interface = self._interfaces(node)
        for event in interface.events:
            yield End(event, frozenset(interface.outputs), counts)
        if node.timeout_s is not None and not interface.own_time:
            yield End("timed_out", frozenset(), counts)

    def _simultaneous(self, chart: Chart, path: str, counts: Counts) -> Iterator[End]:
        values = _Values(chart, self._interfaces)
        place = Place("", values.given(), counts)
        ends = {
            node.id: list(self._visit(node, place, f"{path}/{node.id}", values))
            for node in chart.nodes
        }
        nodes = {node.id: node for node in chart.nodes}
        seen: set[frozenset[tuple[str, End]]] = set()
        waiting: list[frozenset[tuple[str, End]]] = [frozenset()]
        while waiting:
            done = waiting.pop()
            if done in seen:
                continue
            if len(seen) > MOST_PLACES:
                raise TooManyRunsError(path)
            seen.add(done)
            ended = dict(done)
            events = {node_id: end.event for node_id, end in ended.items()}
            fulfilled = fulfilled_outcome(chart.conditions, events)
            if fulfilled is not None:
                memory = values.given()
                for node_id, end in ended.items():
                    memory = values.written(nodes[node_id], end.written, memory)
                visits: dict[str, int] = {}
                for count_path, count in {c for end in ended.values() for c in end.counts}:
                    visits[count_path] = max(count, visits.get(count_path, 0))
                yield End(fulfilled, values.outputs(memory), frozenset(visits.items()))
            elif len(ended) == len(nodes):
                each = ", ".join(f"{node_id} {event}" for node_id, event in sorted(events.items()))
                self.faults.append(Fault(path, f"waits forever after {each}"))
            else:
                for node_id in nodes.keys() - ended.keys():
                    waiting.extend(done | {(node_id, end)} for end in ends[node_id])

    def _find_endless(
        self, after: Mapping[Place, Iterable[Place]], outcomes: set[str], path: str
    ) -> None:
        """Report places from which no outcome can be reached."""
        before: dict[Place, list[Place]] = {}
        for place, nexts in after.items():
            for following in nexts:
                before.setdefault(following, []).append(place)
        ending = {place for place in after if place.target in outcomes}
        waiting = list(ending)
        while waiting:
            for place in before.get(waiting.pop(), ()):
                if place not in ending:
                    ending.add(place)
                    waiting.append(place)
        for place in after:
            if place not in ending:
                self.faults.append(Fault(f"{path}/{place.target}", "leads to no outcome"))


def is_concurrent(chart: Chart) -> bool:
    """Return whether a chart is the content of a concurrency container."""
    return not chart.initial


def fulfilled_outcome(conditions: Iterable[Condition], events: Mapping[str, str]) -> str | None:
    """Return the outcome of the first condition that holds, None if none does."""
    for condition in conditions:
        if all(events.get(when.state) == when.event for when in condition.all_of):
            return condition.outcome
    return None


class _Values:
    """What is one value in a chart: inputs and outputs that are joined, by whatever joins them."""

    def __init__(self, chart: Chart, interfaces: Interfaces) -> None:
        self._parent: dict[Hashable, Hashable] = {}
        self._chart = chart
        self._inputs = {port.name for port in chart.inputs}
        self._outputs = {port.name for port in chart.outputs}
        self._reads = {node.id: _reads(node, interfaces) for node in chart.nodes}
        self._writes = {node.id: _writes(node, interfaces) for node in chart.nodes}
        self._feeds = {
            (flow.input_state_id, flow.input): flow
            for flow in reversed(chart.connections)
            if flow.input_state_id != chart.name
        }
        self._join_all()

    def _join_all(self) -> None:
        name = self._chart.name
        for (node, key), flow in self._feeds.items():
            source = _CHART if flow.output_state_id == name else flow.output_state_id
            self._join(("in", node, key), self._source(source, flow.output))
        for node, keys in self._reads.items():
            for key in keys:
                if (node, key) not in self._feeds and key in self._inputs:
                    self._join(("in", node, key), ("in", _CHART, key))
                if key in self._writes[node]:
                    self._join(("in", node, key), ("out", node, key))
        for output in self._outputs:
            feeding = [
                f for f in self._chart.connections if (f.input_state_id, f.input) == (name, output)
            ]
            for flow in feeding:
                source = _CHART if flow.output_state_id == name else flow.output_state_id
                self._join(("out", _CHART, output), self._source(source, flow.output))
            if not feeding:
                for node, keys in self._writes.items():
                    if output in keys:
                        self._join(("out", _CHART, output), ("out", node, output))
            if output in self._inputs:
                self._join(("out", _CHART, output), ("in", _CHART, output))

    def _source(self, node: str, output: str) -> Hashable:
        return ("in", _CHART, output) if node == _CHART else ("out", node, output)

    def _join(self, one: Hashable, other: Hashable) -> None:
        self._parent[self._value(one)] = self._value(other)

    def _value(self, port: Hashable) -> Hashable:
        while port in self._parent and self._parent[port] != port:
            port = self._parent[port]
        return port

    def given(self) -> Memory:
        """Return what the chart's caller has written."""
        return frozenset((self._value(("in", _CHART, key)), _CHART) for key in self._inputs)

    def complaints(self, node: AnyNode, memory: Memory) -> Iterator[str]:
        """Yield what a node reads that is missing, or that is another's."""
        writers = dict(memory)
        for key in self._reads[node.id]:
            flow = self._feeds.get((node.id, key))
            writer = writers.get(self._value(("in", node.id, key)))
            if flow is None and key not in self._inputs:
                yield f"nothing feeds '{key}'"
            elif writer is None:
                yield f"'{key}' is read before it is written"
            elif flow is not None and writer not in (_CHART, node.id, flow.output_state_id):
                yield f"'{key}' is to come from '{flow.output_state_id}' and comes from '{writer}'"

    def written(self, node: AnyNode, keys: Iterable[str], memory: Memory) -> Memory:
        """Return the memory after a node has written some of its outputs."""
        writers = dict(memory)
        for key in keys:
            writers[self._value(("out", node.id, key))] = node.id
        return frozenset(writers.items())

    def outputs(self, memory: Memory) -> frozenset[str]:
        """Return the outputs of the chart that have been written."""
        writers = dict(memory)
        return frozenset(
            key for key in self._outputs if self._value(("out", _CHART, key)) in writers
        )


def _reads(node: AnyNode, interfaces: Interfaces) -> tuple[str, ...]:
    if isinstance(node, Container):
        return tuple(port.name for port in node.body.inputs)
    return interfaces(node).inputs


def _writes(node: AnyNode, interfaces: Interfaces) -> tuple[str, ...]:
    if isinstance(node, Container):
        return tuple(port.name for port in node.body.outputs)
    return interfaces(node).outputs
