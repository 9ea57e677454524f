"""What a behavior can do at most, for a person to sign: visits, times, error codes, values.

All of it follows from the chart, and from what its states and nested behaviors declare.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.check import CheckedChart
from flexbe_synthesizer.core.error_routes import codes_of_routes, format_codes, is_named
from flexbe_synthesizer.core.graph import Graph, chart_graph
from flexbe_synthesizer.core.nested import NestedBehaviors
from flexbe_synthesizer.core.resolve import (
    ERROR_CODE,
    FAILED,
    ResolvedChart,
    ResolvedNode,
    Support,
    arguments,
    scopes,
)
from flexbe_synthesizer.core.signature import BehaviorClass, Effect, StateClass
from flexbe_synthesizer.core.visits import Bound, most_visits
from flexbe_synthesizer.core.written import outcome_effects

UNBOUNDED = "unbounded"
_ANY, _OTHER = "any", "other"  # codes: of an outcome without routes, and those without a route
_MOST_NESTED = 40  # behaviors inside each other whose times are added up
_HEAD = """\
# What the behavior can do at most, as proved from its chart. Written with it; do not edit.
"""

Seconds = float | None  # None: nothing bounds it


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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
    outcomes = {outcome.name: frozenset({outcome.name}) for outcome in resolved.chart.outcomes}
    nothing: frozenset[str] = frozenset()
    effects = {
        effect.outcome: effect for effect in outcome_effects(resolved, times.graph(resolved))
    }
    return Certificate(
        resolved.chart.name,
        package,
        times.longest(resolved),
        tuple(_bounds(resolved, "", 1, times)),
        tuple(_error_ends(resolved, "", outcomes, times)),
        tuple(effects.get(name, Effect(name, nothing, nothing)) for name in outcomes),
        tuple(sorted(set(_assumed(resolved)))),
    )


def _bounds(
    resolved: ResolvedChart, above: str, entries: Bound, times: _Times
) -> Iterator[StateBound]:
    """Yield the bounds of all nodes of a chart or container that is entered so often."""
    visits = times.visits(resolved, entries)
    for name, entry in resolved.by_id.items():
        visit_s = times.visit(entry)
        longest = _product(visits[name], visit_s)
        yield StateBound(f"{above}{name}", visits[name], visit_s, longest)
        if entry.body is not None:
            yield from _bounds(entry.body, f"{above}{name}/", visits[name], times)


class _Times:
    """How long things take at most [s]."""

    def __init__(self, nested: NestedBehaviors, depth: int = 0) -> None:
        self._nested = nested
        self._depth = depth
        self._known: dict[str, Seconds] = {}
        self._longest: dict[ResolvedChart, Seconds] = {}
        self._graphs: dict[ResolvedChart, Graph] = {}
        self._visits: dict[tuple[ResolvedChart, Bound], Mapping[str, Bound]] = {}

    def graph(self, resolved: ResolvedChart) -> Graph:
        """Return the graph of a chart or container."""
        if resolved not in self._graphs:
            self._graphs[resolved] = chart_graph(resolved)
        return self._graphs[resolved]

    def visits(self, resolved: ResolvedChart, entries: Bound) -> Mapping[str, Bound]:
        """Return how often each node of a chart or container runs that is entered so often."""
        key = (resolved, entries)
        if key not in self._visits:
            self._visits[key] = most_visits(resolved, self.graph(resolved), entries)
        return self._visits[key]

    def longest(self, resolved: ResolvedChart) -> Seconds:
        """Return how long a chart, or one entry of a container, takes."""
        if resolved not in self._longest:
            self._longest[resolved] = self._sum(resolved)
        return self._longest[resolved]

    def _sum(self, resolved: ResolvedChart) -> Seconds:
        if resolved.is_concurrent:
            every = [self.visit(entry) for entry in resolved.by_id.values()]
            return None if None in every else max((s for s in every if s is not None), default=0.0)
        total = 0.0
        for name, visits in self.visits(resolved, 1).items():
            longest = _product(visits, self.visit(resolved.by_id[name]))
            if longest is None:
                return None
            total += longest
        return total

    def visit(self, entry: ResolvedNode) -> Seconds:
        """Return how long one visit to a node takes."""
        inside = self._inside(entry)
        limit = entry.node.timeout_s if entry.use.is_timed else None
        return min((s for s in (inside, limit) if s is not None), default=None)

    def _inside(self, entry: ResolvedNode) -> Seconds:
        declaration = entry.use.declaration
        if entry.body is not None:
            return self.longest(entry.body)
        if isinstance(declaration, BehaviorClass):
            return self._behavior(declaration)
        if declaration is None:
            return None
        timer = Support.TIMER
        is_timer = (declaration.package, declaration.name) == (timer.package, timer.class_name)
        wanted = "wait_time" if is_timer else "timeout_s"
        default = next((p.default for p in declaration.parameters if p.name == wanted), None)
        value = arguments(entry.node, entry.use.is_timed).get(wanted, default)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return float(value) if is_number and isinstance(value, int | float) else None

    def _behavior(self, behavior: BehaviorClass) -> Seconds:
        if behavior.module not in self._known:
            resolved = self._nested.resolved(behavior) if self._depth < _MOST_NESTED else None
            inner = _Times(self._nested, self._depth + 1)
            self._known[behavior.module] = None if resolved is None else inner.longest(resolved)
        return self._known[behavior.module]


def _product(visits: Bound, seconds: Seconds) -> Seconds:
    """Return how long so many visits take; no visit takes no time."""
    if visits == 0:
        return 0.0
    return None if visits is None or seconds is None else visits * seconds


def _error_ends(
    resolved: ResolvedChart, above: str, leading: Mapping[str, frozenset[str]], times: _Times
) -> Iterator[ErrorEnd]:
    """Yield where error codes end.

    Args:
        resolved: the chart, or the content of a container.
        above: path of the container, with a slash at its end.
        leading: the outcomes of the behavior that each outcome of the container leads to.
        times: which knows the graphs.
    """
    graph = times.graph(resolved)
    ends = _ends(graph, leading)
    for name, entry in resolved.by_id.items():
        for edge_event, codes, target in _coded(entry, graph, resolved.error_names):
            found = tuple(sorted(ends.get(target, ())))
            yield ErrorEnd(f"{above}{name}", edge_event, codes, target, found)
        if entry.body is not None:
            inner: dict[str, frozenset[str]] = {}
            for edge in graph.leaving.get(name, ()):
                inner[edge.event] = inner.get(edge.event, frozenset()) | ends.get(
                    edge.target, frozenset()
                )
            yield from _error_ends(entry.body, f"{above}{name}/", inner, times)


def _ends(graph: Graph, leading: Mapping[str, frozenset[str]]) -> Mapping[str, frozenset[str]]:
    """Return the outcomes of the behavior that can be reached from each state."""
    ends = dict(leading)
    waiting = list(leading)
    while waiting:
        target = waiting.pop()
        for edge in graph.entering.get(target, ()):
            old = ends.get(edge.source, frozenset())
            if not ends[target] <= old:
                ends[edge.source] = old | ends[target]
                waiting.append(edge.source)
    return ends


def _coded(
    entry: ResolvedNode, graph: Graph, error_names: Mapping[str, tuple[int, ...]]
) -> Iterator[tuple[str, str, str]]:
    """Yield event, codes and target of each way in which a node is left with an error code."""
    signature = entry.use.signature
    if signature is None or ERROR_CODE not in entry.use.outputs:
        return
    routes: dict[str, list[str]] = {}
    on_error = entry.node.on_error
    for route, codes in zip(on_error, codes_of_routes(on_error, error_names), strict=True):
        shown = f"{route.codes} ({format_codes(codes)})" if is_named(route) else format_codes(codes)
        routes.setdefault(route.target, []).append(shown)
    targets = {t.event: t.target for t in entry.node.transitions}
    for edge in graph.leaving.get(entry.node.id, ()):
        targets.setdefault(edge.event, edge.target)  # in a concurrency container
    for event in signature.outcomes or ():
        effect = signature.effect(event)
        if (effect is not None and ERROR_CODE not in effect.possible) or event not in targets:
            continue
        if event == FAILED and routes:
            yield from ((event, ", ".join(codes), target) for target, codes in routes.items())
            yield event, _OTHER, targets[event]
        else:
            yield event, _ANY, targets[event]


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


def write_certificate(
    certificate: Certificate, code_sha256: str, manual_code: Iterable[str] = ()
) -> str:
    """Return the certificate as YAML, bound to the text of the behavior's file.

    Args:
        certificate: what to write.
        code_sha256: of the behavior's file.
        manual_code: names of the manual sections in it that are not empty.
    """
    head = {
        "behavior": certificate.behavior,
        "package": certificate.package,
        "code_sha256": code_sha256,
        "manual_code": sorted(manual_code),
        "longest_s": _shown(certificate.longest_s),
    }
    states = (
        {
            "path": bound.path,
            "visits": _shown(bound.visits),
            "visit_s": _shown(bound.visit_s),
            "longest_s": _shown(bound.longest_s),
        }
        for bound in certificate.states
    )
    errors = (
        {"path": e.path, "event": e.event, "codes": e.codes, "next": e.next, "ends": list(e.ends)}
        for e in certificate.errors
    )
    outcomes = (
        {
            "outcome": effect.outcome,
            "always": sorted(effect.certain),
            "sometimes": sorted(effect.possible - effect.certain),
        }
        for effect in certificate.effects
    )
    lines = [f"{key}: {_yaml(value)}" for key, value in head.items()]
    lines += [*_rows("states", states), *_rows("errors", errors), *_rows("outcomes", outcomes)]
    lines.append(f"assumed: {_yaml(list(certificate.assumed))}")
    return _HEAD + "\n".join(lines) + "\n"


def _shown(bound: float | None) -> float | str:
    return UNBOUNDED if bound is None else bound


def _rows(name: str, rows: Iterable[Mapping[str, object]]) -> Iterator[str]:
    """Yield a list of mappings, one a line."""
    listed = [
        "- {" + ", ".join(f"{key}: {_yaml(value)}" for key, value in row.items()) + "}"
        for row in rows
    ]
    yield f"{name}:" if listed else f"{name}: []"
    yield from listed


def _yaml(value: object) -> str:
    """Return a value as YAML, of which JSON is a part."""
    return json.dumps(value, ensure_ascii=False)
