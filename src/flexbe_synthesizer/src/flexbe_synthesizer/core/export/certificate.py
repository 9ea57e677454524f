"""What a behavior can do at most, for a person to sign: visits, times, error codes, values.

All of it follows from the chart, and from what its states and nested behaviors declare.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from flexbe_synthesizer.core.chart.error_routes import codes_of_routes, format_codes, is_named
from flexbe_synthesizer.core.chart.model import ErrorRoute, quick
from flexbe_synthesizer.core.chart.names import EXHAUSTED, FAILED
from flexbe_synthesizer.core.check.check import CheckedChart, NestedBehaviors
from flexbe_synthesizer.core.library.definite_assignment import Steps
from flexbe_synthesizer.core.library.graph import Graph
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode, scopes
from flexbe_synthesizer.core.library.signature import BehaviorClass, Effect, StateClass

# How often the states of a chart or container can be visited in one run, at most.
#
# A run is cut into stretches at each visit to a state with `ext:attempts`. Within a stretch a state
# is visited once, or nothing bounds it; so its visits are bounded by the stretches that can come to
# it. The bound may be larger than what a run can reach, never smaller.


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


# The certificate


UNBOUNDED = "unbounded"
_ANY, _OTHER = "any", "other"  # codes: of an outcome without routes, and those without a route
_CHART = re.compile(r"^chart: (.*)$", re.MULTILINE)
_MOST_NESTED = 40  # behaviors inside each other whose times are added up
_HEAD = """\
# What the behavior can do at most, as proved from its chart. Written with it; do not edit.
"""

Seconds = float | None  # None: nothing bounds it


@quick
@dataclass(frozen=True, slots=True)
class StateBound:
    """How often a state, behavior or container runs at most, and how long.

    Attributes:
        path: ids from the chart down, `Place/Insert`.
        visits: how often it runs in one run of the behavior.
        visit_s: how long one visit takes [s].
        longest_s: how long all visits take together [s].
    """

    path: str
    visits: Bound
    visit_s: Seconds
    longest_s: Seconds


@quick
@dataclass(frozen=True, slots=True)
class ErrorEnd:
    """Where a state leads when it ends with an error code in a range.

    Attributes:
        path: the state, behavior or container.
        event: what it ends with.
        codes: `304`, `100-199`, `other` or `any`.
        next: where that leads.
        ends: the outcomes of the behavior that can be reached from there.
    """

    path: str
    event: str
    codes: str
    next: str
    ends: tuple[str, ...]


@dataclass(frozen=True)
class Certificate:
    """What a behavior can do at most.

    Attributes:
        longest_s: how long a run takes [s], in the time that its states measure.
        effects: which outputs each outcome writes.
        assumed: state classes that declare no `[writes ...]`, taken to write all their outputs.
    """

    behavior: str
    package: str
    longest_s: Seconds
    states: tuple[StateBound, ...]
    errors: tuple[ErrorEnd, ...]
    effects: tuple[Effect, ...]
    assumed: tuple[str, ...]


def certify(checked: CheckedChart, package: str) -> Certificate:
    """Return the certificate of a chart without errors."""
    resolved = checked.resolved
    times = _Times(checked.nested)
    outcomes = [outcome.name for outcome in resolved.chart.outcomes]
    effects = {effect.outcome: effect for effect in resolved.effects}
    nothing: frozenset[str] = frozenset()
    return Certificate(
        resolved.chart.name,
        package,
        longest_s=times.longest(resolved),
        states=tuple(_bounds(resolved, "", 1, times)),
        errors=tuple(_ErrorEnds(outcomes).of_chart(resolved)),
        effects=tuple(effects.get(name, Effect(name, nothing, nothing)) for name in outcomes),
        assumed=tuple(sorted(set(_assumed(resolved)))),
    )


def _bounds(
    resolved: ResolvedChart, above: str, entries: Bound, times: _Times
) -> Iterator[StateBound]:
    """Yield the bounds of all nodes of a chart or container that is entered so often."""
    for entry, visits, visit_s in times.visits(resolved, entries):
        path = above + entry.node.id
        yield StateBound(path, visits, visit_s, _product(visits, visit_s))
        if entry.body is not None:
            yield from _bounds(entry.body, f"{path}/", visits, times)


_Visits: TypeAlias = tuple[ResolvedNode, Bound, Seconds]  # a node, how often it runs, how long


class _Times:
    """How long things take at most [s]."""

    def __init__(self, nested: NestedBehaviors) -> None:
        self._nested = nested
        self._depth = 0  # of behaviors inside each other, which may contain themselves
        self._known: dict[str, Seconds] = {}
        self._longest: dict[ResolvedChart, Seconds] = {}
        self._visits: dict[tuple[ResolvedChart, Bound], Sequence[_Visits]] = {}

    def visits(self, resolved: ResolvedChart, entries: Bound) -> Sequence[_Visits]:
        """Return the visits to the nodes of a chart or container that is entered so often."""
        key = (resolved, entries)
        if key not in self._visits:
            most = most_visits(resolved, entries)
            by_id = resolved.by_id.items()
            self._visits[key] = [(entry, most[name], self._visit(entry)) for name, entry in by_id]
        return self._visits[key]

    def longest(self, resolved: ResolvedChart) -> Seconds:
        """Return how long a chart, or one entry of a container, takes."""
        if resolved not in self._longest:
            self._longest[resolved] = self._sum(resolved)
        return self._longest[resolved]

    def _sum(self, resolved: ResolvedChart) -> Seconds:
        longest = 0.0
        for _entry, visits, visit_s in self.visits(resolved, 1):
            seconds = _product(visits, visit_s)
            if seconds is None:
                return None
            longest = max(longest, seconds) if resolved.is_concurrent else longest + seconds
        return _finite(longest)

    def _visit(self, entry: ResolvedNode) -> Seconds:
        """Return how long one visit to a node takes."""
        inside = self._inside(entry)
        if not entry.use.is_timed:
            return inside
        limit = entry.node.timeout_s
        return limit if inside is None or limit is None else min(inside, limit)

    def _inside(self, entry: ResolvedNode) -> Seconds:
        declaration = entry.use.declaration
        if entry.body is not None:
            return self.longest(entry.body)
        if isinstance(declaration, BehaviorClass):
            return self._behavior(declaration)
        limit = entry.use.time_limit
        if limit is None:
            return None
        if entry.node.timeout_s is not None and not entry.use.is_timed:
            return _finite(entry.node.timeout_s + limit.grace_s)
        value = next((p.value for p in entry.node.params if p.name == limit.name), limit.default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        return _finite(value + limit.grace_s)

    def _behavior(self, behavior: BehaviorClass) -> Seconds:
        if behavior.module not in self._known:
            resolved = self._nested.resolved(behavior) if self._depth < _MOST_NESTED else None
            self._depth += 1
            self._known[behavior.module] = None if resolved is None else self.longest(resolved)
            self._depth -= 1
        return self._known[behavior.module]


def _product(visits: Bound, seconds: Seconds) -> Seconds:
    """Return how long so many visits take; no visit takes no time."""
    if visits == 0:
        return 0.0
    return None if visits is None or seconds is None else _finite(visits * seconds)


def _finite(seconds: float) -> Seconds:
    """Return a time, None for one that is too long for a number."""
    return seconds if seconds < math.inf else None


class _ErrorEnds:
    """Where error codes end; a set of outcomes of the behavior is one integer, a bit for each."""

    def __init__(self, outcomes: Sequence[str]) -> None:
        self._bits = {name: 1 << index for index, name in enumerate(outcomes)}
        self._names: dict[int, tuple[str, ...]] = {}

    def of_chart(self, resolved: ResolvedChart) -> Iterator[ErrorEnd]:
        """Yield the ends of all error codes of a chart."""
        return self._inside(resolved, "", self._bits)

    def _inside(
        self, resolved: ResolvedChart, above: str, leading: Mapping[str, int]
    ) -> Iterator[ErrorEnd]:
        """Yield the ends of the error codes of a chart, or of the content of a container.

        Args:
            resolved: the chart, or the content of a container.
            above: path of the container, with a slash at its end.
            leading: the outcomes of the behavior that each outcome of the container leads to.
        """
        graph = resolved.graph
        ends = _ends(graph, leading)
        for name, entry in resolved.by_id.items():
            path = above + name
            for event, codes, target in _coded(entry, graph, resolved.error_names):
                yield ErrorEnd(path, event, codes, target, ends=self._listed(ends.get(target, 0)))
            if entry.body is not None:
                inner: dict[str, int] = {}
                for edge in graph.leaving.get(name, ()):
                    inner[edge.event] = inner.get(edge.event, 0) | ends.get(edge.target, 0)
                yield from self._inside(entry.body, f"{path}/", inner)

    def _listed(self, ends: int) -> tuple[str, ...]:
        """Return the names of some outcomes."""
        if ends not in self._names:
            self._names[ends] = tuple(sorted(n for n, bit in self._bits.items() if bit & ends))
        return self._names[ends]


def _ends(graph: Graph, leading: Mapping[str, int]) -> Mapping[str, int]:
    """Return the outcomes of the behavior that can be reached from each state."""
    ends = dict(leading)
    waiting = list(leading)
    while waiting:
        target = waiting.pop()
        found = ends[target]
        for edge in graph.entering.get(target, ()):
            old = ends.get(edge.source, 0)
            if found & ~old:
                ends[edge.source] = old | found
                waiting.append(edge.source)
    return ends


def _coded(
    entry: ResolvedNode, graph: Graph, error_names: Mapping[str, tuple[int, ...]]
) -> Iterator[tuple[str, str, str]]:
    """Yield event, codes and target of each way in which a node is left with an error code."""
    # In a concurrency container a node has no transitions, and its conditions are the edges.
    leads = entry.node.transitions or graph.leaving.get(entry.node.id, ())
    targets = {lead.event: lead.target for lead in leads}
    for event in entry.use.coded_events:
        if event not in targets:
            continue
        if event == FAILED and entry.node.on_error:
            yield from _routed(entry.node.on_error, error_names)
            yield event, _OTHER, targets[event]
        else:
            yield event, _ANY, targets[event]


def _routed(
    routes: Sequence[ErrorRoute], error_names: Mapping[str, tuple[int, ...]]
) -> Iterator[tuple[str, str, str]]:
    """Yield event, codes and target of each target of error routes."""
    by_target: dict[str, list[str]] = {}
    for route, codes in zip(routes, codes_of_routes(routes, error_names), strict=True):
        shown = f"{route.codes} ({format_codes(codes)})" if is_named(route) else format_codes(codes)
        by_target.setdefault(route.target, []).append(shown)
    for target, listed in by_target.items():
        yield FAILED, ", ".join(listed), target


def _assumed(resolved: ResolvedChart) -> Iterator[str]:
    """Yield the state classes with outputs that declare nothing about what they write."""
    for scope in scopes(resolved):
        for entry in scope.nodes:
            declaration = entry.use.declaration
            if (
                isinstance(declaration, StateClass)
                and entry.use.outputs
                and not declaration.effects
            ):
                yield f"{declaration.package}/{declaration.name}"


def read_chart_place(text: str) -> str | None:
    """Return the `chart` of `write_certificate`; None if the certificate states none."""
    found = _CHART.search(text)
    try:
        place = json.loads(found[1]) if found else None
    except ValueError:
        return None
    return place if isinstance(place, str) else None


def write_certificate(
    certificate: Certificate, chart: str, code_sha256: str, manual_code: Iterable[str] = ()
) -> str:
    """Return the certificate as YAML, bound to the text of the behavior's file.

    Args:
        certificate: what to write.
        chart: path of the chart's file, relative to the folder of the behavior's package.
        code_sha256: of the behavior's file.
        manual_code: names of the manual sections in it that are not empty.
    """
    text = cache(_yaml)  # many rows have the same
    errors = [
        f"{{path: {text(e.path)}, event: {text(e.event)}, codes: {text(e.codes)}, "
        f"next: {text(e.next)}, ends: {text(e.ends)}}}"
        for e in certificate.errors
    ]
    states = [
        f"{{path: {text(s.path)}, visits: {_number(s.visits)}, visit_s: {_number(s.visit_s)}, "
        f"longest_s: {_number(s.longest_s)}}}"
        for s in certificate.states
    ]
    outcomes = [
        f"{{outcome: {text(e.outcome)}, always: {_names(e.certain)}, "
        f"sometimes: {_names(e.possible - e.certain)}}}"
        for e in certificate.effects
    ]
    lines = [
        f"behavior: {_yaml(certificate.behavior)}",
        f"package: {_yaml(certificate.package)}",
        f"chart: {_yaml(chart)}",
        f"code_sha256: {_yaml(code_sha256)}",
        f"manual_code: {_names(manual_code)}",
        f"longest_s: {_number(certificate.longest_s)}",
        *_rows("states", states),
        *_rows("errors", errors),
        *_rows("outcomes", outcomes),
        f"assumed: {_names(certificate.assumed)}",
    ]
    return _HEAD + "\n".join(lines) + "\n"


# YAML holds JSON.
_yaml = json.JSONEncoder(ensure_ascii=False).encode


def _number(bound: float | None) -> str:
    if bound is None:
        return f'"{UNBOUNDED}"'
    written = repr(bound)
    return written if "." in written else written.replace("e", ".0e")  # YAML wants the point


def _names(names: Iterable[str]) -> str:
    return f"[{', '.join(map(_yaml, sorted(names)))}]"


def _rows(name: str, rows: Sequence[str]) -> list[str]:
    """Return the lines of a list of mappings, one a line."""
    return [f"{name}:", *(f"- {row}" for row in rows)] if rows else [f"{name}: []"]
