"""Check that each event of each state has exactly one transition, to something that exists."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import Transition
from flexbe_synthesizer.core.chart.names import EXHAUSTED, TIMED_OUT
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode
from flexbe_synthesizer.core.library.use import label

_ADDED_BY = {EXHAUSTED: "attempts", TIMED_OUT: "timeout_s"}


def check_transitions(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the initial state, the targets and the outcomes."""
    chart = resolved.chart
    if resolved.is_concurrent:
        yield from _check_outcomes(resolved, {condition.outcome for condition in chart.conditions})
        return
    if chart.initial and chart.initial not in resolved.by_id:
        hint = names.allowed(chart.initial, resolved.ids)
        message = f"the initial state '{chart.initial}' does not exist; {hint}"
        yield Problem(chart.position("initial"), ProblemKind.UNKNOWN_INITIAL, message)
    known = set(resolved.targets)
    targets = {t.target for node in chart.nodes for t in node.transitions}
    if not targets <= known:
        for entry in resolved.nodes:
            for transition in entry.node.transitions:
                if transition.target and transition.target not in known:
                    yield _unknown_target(transition, resolved.targets)
    targets |= {route.target for node in chart.nodes for route in node.on_error}
    yield from _check_outcomes(resolved, targets)


def _check_outcomes(resolved: ResolvedChart, targets: Collection[str]) -> Iterator[Problem]:
    """Warn of each outcome that nothing leads to."""
    for outcome in resolved.chart.outcomes:
        if outcome.name and outcome.name not in targets:
            message = f"no transition leads to the outcome '{outcome.name}'; delete it, or add a "
            message += "transition to it."
            yield Problem(outcome.position("name"), ProblemKind.UNUSED_OUTCOME, message)


def check_events(entry: ResolvedNode) -> Iterator[Problem]:
    """Yield the problems with the events of one state or behavior."""
    first: dict[str, Transition] = {}
    meant: set[str] = set()  # by misspelt events, whose mending also mends what is missing
    events = entry.use.events
    for transition in entry.node.transitions:
        other = first.setdefault(transition.event, transition)
        if not transition.event:
            continue
        if transition.event == names.PREEMPTED:
            message = "'preempted' is reserved: FlexBE leads it to the end itself; delete this."
            yield Problem(transition.position("event"), ProblemKind.RESERVED_NAME, message)
        elif events is not None and transition.event not in events:
            meant.add(names.misspelt(transition.event, events) or "")
            message = f"{label(entry.node)} has no outcome '{transition.event}'; "
            message += _hint(entry, transition.event)
            yield Problem(transition.position("event"), ProblemKind.UNKNOWN_EVENT, message)
        elif other is not transition:
            line = other.position("event").line
            message = f"'{transition.event}' of {label(entry.node)} has a transition in line {line}"
            message += " already; delete one."
            yield Problem(transition.position("event"), ProblemKind.DUPLICATE_TRANSITION, message)
    for event in events or ():
        if event not in first and event not in meant:
            cause = f", which ext:{_ADDED_BY[event]} adds," if event in _ADDED_BY else ""
            message = f"outcome '{event}' of {label(entry.node)}{cause} leads nowhere; add "
            message += f'<transition event="{event}" target="..."/>.'
            yield Problem(entry.node.position(), ProblemKind.MISSING_TRANSITION, message)


def _hint(entry: ResolvedNode, event: str) -> str:
    hint = names.allowed(event, entry.use.events or ())
    if event == EXHAUSTED and entry.node.attempts is None:
        hint += " For 'exhausted', limit the attempts with ext:attempts."
    return hint


def _unknown_target(transition: Transition, known: names.Vocabulary) -> Problem:
    target = names.shortened(transition.target)
    message = f"'{target}' is neither a state, a behavior nor an outcome; "
    message += names.allowed(transition.target, known)
    return Problem(transition.position("target"), ProblemKind.UNKNOWN_TARGET, message)
