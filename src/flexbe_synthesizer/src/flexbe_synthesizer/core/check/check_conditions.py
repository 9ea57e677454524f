"""Check that a concurrency container ends, whatever the states in it end with.

FlexBE ends such a container when all that one of its conditions waits for has happened; if all
states have ended and no condition holds, it waits forever. Since each event stands in one
condition (the FlexBE App can read no other), whether that can happen is a question about a graph:
let states and conditions be its vertices, and join a state with each condition that waits for it
together with others. A state that a condition waits for alone may not be among them: its event
ends the container. Some choice of one event for each state leaves every condition open if and only
if each connected part of this graph has a cycle; in a part that is a tree, there are too few events
to leave all its conditions open. The choice is found by giving each vertex an edge of its own: a
state ends with its edge, a condition is kept open by its edge not being chosen.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import When
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.use import label


def check_conditions(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the conditions of a concurrency container."""
    if not resolved.is_concurrent:
        return
    problems = [*_check_names(resolved), *_check_events(resolved)]
    yield from problems
    if not problems:
        yield from _check_end(resolved)


def _check_names(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each condition that names what does not exist, or one thing twice."""
    outcomes = [outcome.name for outcome in resolved.chart.outcomes]
    first: dict[tuple[str, str], When] = {}
    for condition in resolved.chart.conditions:
        if condition.outcome and condition.outcome not in outcomes:
            hint = names.allowed(condition.outcome, names.Vocabulary(outcomes))
            message = f"{resolved.title} has no outcome '{condition.outcome}'; {hint}"
            yield Problem(condition.position("outcome"), ProblemKind.UNKNOWN_TARGET, message)
        waited: set[str] = set()
        for when in condition.all_of:
            yield from _check_when(when, resolved)
            other = first.setdefault((when.state, when.event), when)
            if when.state in waited:
                message = f"'{when.state}' cannot end twice; put its events into two conditions."
                yield Problem(when.position(), ProblemKind.DUPLICATE_TRANSITION, message)
            elif other is not when:
                line = other.position().line
                message = f"'{when.event}' of '{when.state}' stands in a condition in line {line} "
                message += "already, and the FlexBE App reads each event once; delete one."
                yield Problem(when.position(), ProblemKind.DUPLICATE_TRANSITION, message)
            waited.add(when.state)


def _check_when(when: When, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem if the state, or its event, does not exist."""
    entry = resolved.by_id.get(when.state)
    if when.state and entry is None:
        hint = names.allowed(when.state, resolved.ids)
        message = f"'{when.state}' is no state in {resolved.title}; {hint}"
        yield Problem(when.position("state"), ProblemKind.UNKNOWN_STATE, message)
    events = entry.use.events if entry else None
    if entry and events is not None and when.event and when.event not in events:
        hint = names.allowed(when.event, events)
        message = f"{label(entry.node)} has no outcome '{when.event}'; {hint}"
        yield Problem(when.position("event"), ProblemKind.UNKNOWN_EVENT, message)


def _check_events(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each event of a state that no condition waits for."""
    waited: dict[str, set[str]] = defaultdict(set)
    for condition in resolved.chart.conditions:
        for when in condition.all_of:
            waited[when.state].add(when.event)
    for name, entry in resolved.by_id.items():
        meant = {names.misspelt(e, entry.use.events or ()) for e in waited[name]}
        for event in entry.use.events or ():
            if event not in waited[name] and event not in meant:
                message = f"no condition waits for '{event}' of {label(entry.node)}; add "
                message += f'<ext:when state="{name}" event="{event}"/> to an <ext:condition>.'
                yield Problem(entry.node.position(), ProblemKind.MISSING_TRANSITION, message)


def _check_end(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem if all states can end with no condition fulfilled, with an example."""
    stuck = _endless_choice(resolved)
    if stuck:
        choice = ", ".join(f"{state} -{event}" for state, event in stuck.items())
        message = f"when the states end with {choice}, no condition of {resolved.title} holds, and "
        message += "it waits forever; give one of these events a condition of its own."
        yield Problem(resolved.chart.position("name"), ProblemKind.ENDLESS_CONTAINER, message)


def _endless_choice(resolved: ResolvedChart) -> Mapping[str, str]:
    """Return an event for each state such that no condition holds; empty if there is none."""
    conditions = resolved.chart.conditions
    edges = [
        (when.state, number, when.event)
        for number, condition in enumerate(conditions)
        if len(condition.all_of) > 1
        for when in condition.all_of
    ]
    touching: dict[str | int, set[int]] = defaultdict(set)
    for index, (state, number, _event) in enumerate(edges):
        touching[state].add(index)
        touching[number].add(index)
    if any(state not in touching for state in resolved.by_id):
        return {}
    owned: dict[str | int, int] = {}

    def own(vertex: str | int, index: int) -> str | int:
        """Give a vertex an edge, and return the vertex at the edge's other end."""
        owned[vertex] = index
        state, number, _event = edges[index]
        other = number if vertex == state else state
        touching[vertex].discard(index)
        touching[other].discard(index)
        return other

    leaves = [vertex for vertex, around in touching.items() if len(around) == 1]
    while leaves or len(owned) < len(touching):
        # What is no leaf lies on a cycle, or between cycles: any edge will do, and makes leaves.
        vertex = leaves.pop() if leaves else next(v for v in touching if v not in owned)
        if vertex in owned:
            continue
        if not touching[vertex]:
            return {}
        other = own(vertex, min(touching[vertex]))
        if len(touching[other]) == 1:
            leaves.append(other)
    return {state: edges[owned[state]][2] for state in resolved.by_id}
