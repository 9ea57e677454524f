"""What synthesis says of a chart: what is asked of it, its problems, and its certificate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from html import escape

from flexbe_synthesizer.core.chart.model import AnyNode, Chart
from flexbe_synthesizer.core.chart.problem import Problem, errors_in
from flexbe_synthesizer.core.check.check import CheckedChart
from flexbe_synthesizer.core.export.certificate import Certificate, ErrorEnd, certify
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.signature import Effect
from flexbe_synthesizer.core.library.use import Use


@dataclass(frozen=True)
class ServerRequest:
    """A request to a synthesis server.

    Attributes:
        topic: name of its action.
        system: name of the robot system; may be empty.
        path: of the container to fill, such as `/Place/Insert`.
        initial: where it starts; empty for where the chart itself does.
        goal: path of the chart.
    """

    topic: str
    system: str
    path: str
    initial: str
    goal: str


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
