"""A certificate as the tables that the editor shows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from html import escape

from flexbe_synthesizer.core.export.certificate import Certificate, ErrorEnd
from flexbe_synthesizer.core.library.signature import Effect

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
