"""What synthesis says of a chart: problems, fixes and certificate."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from html import escape
from typing import TypeAlias

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Container,
    Element,
    Input,
    Outcome,
    Param,
    Transition,
)
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind, Severity, errors_in
from flexbe_synthesizer.core.check.check import CheckedChart
from flexbe_synthesizer.core.export.certificate import Certificate, ErrorEnd, certify
from flexbe_synthesizer.core.export.draw import is_failure_name
from flexbe_synthesizer.core.library.data_flow import Use
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.signature import Effect
from remodel_console.core import chart_edit
from remodel_console.core.chart_edit import with_input
from remodel_console.core.editing import Path, change_at, container_at


@dataclass(frozen=True)
class Inspection:
    """What the checks found.

    Attributes:
        problems: those of this file first.
        uses: what nodes name, by their paths, `Place/Insert`.
        unchecked: why it could not be checked; empty if it was.
        checked: the chart, if it was.
        package: where its behavior goes.
    """

    problems: tuple[Problem, ...] = ()
    uses: Mapping[str, Use] = field(default_factory=dict)
    unchecked: str = ""
    checked: CheckedChart | None = None
    package: str = ""

    def certify(self) -> Certificate | None:
        """Return what the behavior can do at most; None if it has errors."""
        if self.checked is None or self.error_count:
            return None
        return certify(self.checked, self.package)

    @property
    def error_count(self) -> int:
        """Return how many problems keep it from being saved."""
        return len(errors_in(self.problems))

    def events(self, path: str, node: AnyNode) -> tuple[str, ...]:
        """Return the outcomes of a node, those that only its transitions name too."""
        entry = self.uses.get(path)
        known = (entry.events or ()) if entry else ()
        return tuple(dict.fromkeys((*known, *(t.event for t in node.transitions))))

    def sources(self, scope: Chart, prefix: str) -> Iterator[tuple[str, str]]:
        """Yield the (state, output) pairs that an input in a scope may be fed by."""
        yield from ((scope.name, port.name) for port in scope.inputs)
        for node in scope.nodes:
            entry = self.uses.get(f"{prefix}{node.id}")
            for port in entry.outputs.values() if entry else ():
                yield node.id, port.name


def uses_by_path(resolved: ResolvedChart, prefix: str = "") -> dict[str, Use]:
    """Return what each node of a chart names, those inside containers too."""
    found: dict[str, Use] = {}
    for entry in resolved.nodes:
        path = f"{prefix}{entry.node.id}"
        found[path] = entry.use
        if entry.body is not None:
            found |= uses_by_path(entry.body, f"{path}/")
    return found


_UNBOUNDED = "unbounded"
_NO_LIMIT = "The time of a run has no bound: it can visit a state without a time limit."


def certificate_html(certificate: Certificate) -> str:
    """Return what a behavior can do at most, as HTML."""
    states = [
        (s.path, _number(s.visits), _time(s.visit_s), _time(s.longest_s))
        for s in certificate.states
    ]
    errors = [(e.path, _cause(e), f"{e.next} → {', '.join(e.ends)}") for e in certificate.errors]
    has_outputs = any(effect.possible for effect in certificate.effects)
    outcomes = [(e.outcome, *_writes(e)) for e in certificate.effects if has_outputs]
    longest = certificate.longest_s
    words = f"A run takes at most {longest:g} s." if longest is not None else _NO_LIMIT
    parts = [
        f"<p>{words}</p>",
        _table("Longest times", ("state", "visits", "one visit", "all visits"), states),
        _table("Error codes", ("state", "code", "next → can end in"), errors),
        _table("Outputs written", ("outcome", "always", "sometimes"), outcomes),
    ]
    if certificate.assumed:
        classes = escape(", ".join(certificate.assumed))
        parts.append(f"<p>Assumed to write all their outputs: {classes}.</p>")
    return "".join(parts)


def _cause(end: ErrorEnd) -> str:
    """Return the outcome and the codes that lead somewhere."""
    return f"{end.event} {end.codes}" if end.codes != "any" else end.event


def _writes(effect: Effect) -> tuple[str, str]:
    """Return the outputs that an outcome writes always, and sometimes."""
    sometimes = effect.possible - effect.certain
    return ", ".join(sorted(effect.certain)), ", ".join(sorted(sometimes))


def _number(visits: int | None) -> str:
    return _UNBOUNDED if visits is None else str(visits)


def _time(seconds: float | None) -> str:
    return _UNBOUNDED if seconds is None else f"{seconds:g} s"


def _table(title: str, heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table with a title; nothing if it has no rows."""
    body = "".join(f"<tr>{''.join(_cells(row, 'td'))}</tr>" for row in rows)
    if not body:
        return ""
    head = "".join(_cells(heads, "th"))
    return f"<table><caption>{title}</caption><tr>{head}</tr>{body}</table>"


def _cells(texts: Iterable[str], tag: str) -> Iterator[str]:
    yield from (f"<{tag}>{escape(text)}</{tag}>" for text in texts)


Change: TypeAlias = Callable[[Chart], Chart]
_MOST_FIXES = 3  # of one problem; more are no help to choose


@dataclass(frozen=True)
class Fix:
    """A change that corrects a problem: what it does, and the container that it is made in."""

    words: str
    path: Path
    change: Change


@dataclass(frozen=True)
class Found:
    """A problem, the path of the state that it is at (empty: the chart itself), and its fixes."""

    problem: Problem
    path: Path = ()
    fixes: tuple[Fix, ...] = ()


def located(inspection: Inspection) -> tuple[Found, ...]:
    """Return the problems with the states that they are at, and what corrects them."""
    checked = inspection.checked
    if checked is None or not inspection.problems:
        return tuple(map(Found, inspection.problems))
    chart = checked.resolved.chart
    owned = sorted(_owned(chart, ()), key=lambda one: one[0].position()[1:])
    places = [element.position()[1:] for element, _ in owned]
    found = []
    for problem in inspection.problems:
        index = bisect_right(places, problem.position[1:]) - 1
        if problem.position.file != chart.file or index < 0:
            found.append(Found(problem))
            continue
        element, path = owned[index]
        fixes = tuple(_fixes(problem, element, path, chart, inspection))[:_MOST_FIXES]
        found.append(Found(problem, path, fixes))
    return tuple(found)


def unambiguous(found: Iterable[Found]) -> tuple[Fix, ...]:
    """Return the only changes that correct errors of which each has no other."""
    errors = (one for one in found if one.problem.code.severity is Severity.ERROR)
    return tuple(one.fixes[0] for one in errors if len(one.fixes) == 1)


def fixed(chart: Chart, fixes: Iterable[Fix]) -> Chart:
    """Return the chart with the changes made."""
    for fix in fixes:
        chart = change_at(chart, fix.path, fix.change)
    return chart


def counts(found: Iterable[Found]) -> dict[str, tuple[int, int]]:
    """Return the numbers of errors and warnings by the path of the state, `Place/Insert`."""
    numbers: dict[str, tuple[int, int]] = {}
    for one in found:
        if one.path:
            errors, warnings = numbers.get("/".join(one.path), (0, 0))
            is_error = one.problem.code.severity is Severity.ERROR
            numbers["/".join(one.path)] = (errors + is_error, warnings + (not is_error))
    return numbers


def _owned(scope: Chart, path: Path) -> Iterator[tuple[Element, Path]]:
    """Yield the elements of a chart, each with the path of its state."""
    if not path:
        yield scope, path
    for part in (*scope.outcomes, *scope.inputs, *scope.outputs, *scope.connections):
        yield part, path
    for condition in scope.conditions:
        yield condition, path
        yield from ((when, path) for when in condition.all_of)
    for node in scope.nodes:
        inner = (*path, node.id)
        yield node, inner
        for part in (*node.transitions, *node.inputs, *node.outputs, *node.params):
            yield part, inner
        if isinstance(node, Container):
            yield from _owned(node.body, inner)


def _fixes(
    problem: Problem, element: Element, path: Path, chart: Chart, inspection: Inspection
) -> Iterator[Fix]:
    """Yield the changes that may correct a problem, the likeliest first."""
    kind = problem.code
    if isinstance(element, Outcome) and kind is ProblemKind.UNUSED_OUTCOME:
        kept = tuple(o.name for o in container_at(chart, path).outcomes if o.name != element.name)
        if kept:
            change = partial(chart_edit.with_outcomes, wanted=kept)
            yield Fix(f"Delete the outcome '{element.name}'", path, change)
    elif isinstance(element, Input) and kind is ProblemKind.UNUSED_INPUT:
        place = container_at(chart, path).inputs.index(element)
        change = partial(with_input, place=place, name="", kind="", default="")
        yield Fix(f"Delete the input '{element.name}'", path, change)
    elif kind is ProblemKind.UNKNOWN_INITIAL:
        yield from _starts(container_at(chart, path), path)
    elif path:
        node = chart_edit.node_at(chart, path)
        if node is not None:
            yield from _fixes_of_node(problem, element, node, path, chart, inspection)


def _starts(scope: Chart, path: Path) -> Iterator[Fix]:
    ids = [node.id for node in scope.nodes]
    meant = names.misspelt(scope.initial, ids)
    for node_id in [meant] if meant else ids:
        yield Fix(f"Start at '{node_id}'", path, partial(chart_edit.started_at, node_id=node_id))


def _fixes_of_node(
    problem: Problem,
    element: Element,
    node: AnyNode,
    path: Path,
    chart: Chart,
    inspection: Inspection,
) -> Iterator[Fix]:
    kind, outside = problem.code, path[:-1]
    scope = container_at(chart, outside)
    use = inspection.uses.get("/".join(path))
    if kind is ProblemKind.MISSING_TRANSITION:
        led = {transition.event for transition in node.transitions}
        for event in (use.events or ()) if use else ():
            if event not in led and f"'{event}'" in problem.message:
                for target in _likely_targets(scope, node, event):
                    change = partial(chart_edit.led, node_id=node.id, event=event, target=target)
                    yield Fix(f"Connect '{event}' to '{target}'", outside, change)
    elif isinstance(element, Transition) and kind is ProblemKind.UNKNOWN_TARGET:
        event, targets = element.event, list(chart_edit.targets(scope))
        meant = names.misspelt(element.target, targets)
        for target in [meant] if meant else _likely_targets(scope, node, event):
            change = partial(chart_edit.led, node_id=node.id, event=event, target=target)
            yield Fix(f"Connect '{event}' to '{target}'", outside, change)
    elif isinstance(element, Transition) and kind in (
        ProblemKind.UNKNOWN_EVENT,
        ProblemKind.DUPLICATE_TRANSITION,
        ProblemKind.RESERVED_NAME,
    ):
        place = node.transitions.index(element)
        change = partial(_without_transition, node_id=node.id, place=place)
        yield Fix(f"Delete the transition '{element.event}'", outside, change)
    elif isinstance(element, Param) and kind is ProblemKind.UNKNOWN_PARAMETER:
        change = partial(chart_edit.with_parameter, node_id=node.id, name=element.name, text="")
        yield Fix(f"Delete the parameter '{element.name}'", outside, change)
    elif kind is ProblemKind.UNREACHABLE_STATE:
        change = partial(chart_edit.without_node, node_id=node.id)
        yield Fix(f"Delete '{node.id}'", outside, change)
        yield Fix(f"Start at '{node.id}'", outside, partial(chart_edit.started_at, node_id=node.id))
    elif kind is ProblemKind.UNBOUND_INPUT and use is not None:
        for name, port in use.inputs.items():
            if f"'{name}'" in problem.message and name not in {p.name for p in scope.inputs}:
                change = partial(_with_new_input, name=name, kind=port.type or "")
                yield Fix(f"Make '{name}' an input of '{scope.name}'", outside, change)


def _likely_targets(scope: Chart, node: AnyNode, event: str) -> Iterator[str]:
    """Yield where an outcome probably leads: to its namesake, the next state, or an end alike."""
    outcomes = [outcome.name for outcome in scope.outcomes]
    if event in outcomes:
        yield event
    ids = [other.id for other in scope.nodes]
    following = ids[ids.index(node.id) + 1 :]
    if following and not is_failure_name(event):
        yield following[0]
    yield from (o for o in outcomes if o != event and is_failure_name(o) == is_failure_name(event))


def _without_transition(scope: Chart, node_id: str, place: int) -> Chart:
    def put(node: AnyNode) -> AnyNode:
        left = node.transitions[:place] + node.transitions[place + 1 :]
        return replace(node, transitions=left)

    return chart_edit.with_changed(scope, node_id, put)


def _with_new_input(scope: Chart, name: str, kind: str) -> Chart:
    return with_input(scope, len(scope.inputs), name, kind, "")
