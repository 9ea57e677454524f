"""Check what leads where: each event, the ends of concurrency containers, reachability, loops."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import Transition, When
from flexbe_synthesizer.core.chart.names import EXHAUSTED, TIMED_OUT
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import label
from flexbe_synthesizer.core.library.graph import Graph, path_text, reachable, shortest_path
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode

# Each event of each state has exactly one transition, to something that exists


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
            is_added = event in entry.use.added_events
            cause = f", which ext:{_ADDED_BY[event]} adds," if is_added else ""
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


# Check that a concurrency container ends, whatever the states in it end with.
#
# FlexBE ends such a container when all that one of its conditions waits for has happened; if all
# states have ended and no condition holds, it waits forever. Since each event stands in one
# condition (the FlexBE App can read no other), whether that can happen is a question about a graph:
# let states and conditions be its vertices, and join a state with each condition that waits for it
# together with others. A state that a condition waits for alone may not be among them: its event
# ends the container. Some choice of one event for each state leaves every condition open if and
# only if each connected part of this graph has a cycle; in a part that is a tree, there are too few
# events to leave all its conditions open. The choice is found by giving each vertex an edge of its
# own: a state ends with its edge, a condition is kept open by its edge not being chosen.


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


# Check that every state can be reached, and that every state can reach an end


_MOST_LISTED = 50  # dead ends that are reported with all that they lead to
_MORE = "states that do not end either"


def check_reachability(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a problem for each state that is never entered, or never left for good."""
    if resolved.is_concurrent:
        return
    by_id, reached, initial = resolved.by_id, graph.reached, graph.initial
    if initial not in by_id:
        return
    for name, entry in by_id.items():
        if name not in reached:
            message = f"no path from the initial state '{initial}' leads to "
            message += f"{label(entry.node)}; add a transition to it, or delete it."
            yield Problem(entry.node.position(), ProblemKind.UNREACHABLE_STATE, message)
    spent = _spent(graph, resolved)
    ending_when_spent = _ending(graph, spent)
    if ending_when_spent >= reached:
        return
    ending, shown = _ending(graph, frozenset()), _MOST_LISTED
    for name, entry in by_id.items():
        if name in ending_when_spent or name not in reached or not entry.node.transitions:
            continue
        shown -= 1
        if name not in ending:
            message = f"from {label(entry.node)} no outcome of {resolved.title} can be reached; it "
            found = _led_to(name, graph, frozenset()) if shown >= 0 else _MORE
            message += f"leads only to {found}. Add a transition to an "
            yield Problem(entry.node.position(), ProblemKind.NO_WAY_OUT, message + "outcome.")
        elif any(edge.is_exhausted for edge in graph.leaving.get(name, ())):
            message = f"once {label(entry.node)} has had its attempts, no outcome of "
            message += f"{resolved.title} can be reached; '{EXHAUSTED}' leads only to "
            message += f"{_led_to(name, graph, spent) if shown >= 0 else _MORE}. Lead it to an "
            message += "outcome."
            yield Problem(entry.node.position(), ProblemKind.NO_WAY_OUT, message)


def _spent(graph: Graph, resolved: ResolvedChart) -> frozenset[str]:
    """Return the states that can have had all their attempts.

    A state that never leads to itself never runs out of attempts, unless the container that it
    is in is entered again.
    """
    if resolved.is_repeated:
        return frozenset(graph.counted)
    loops = graph.loops
    return frozenset(
        name
        for name in graph.counted
        for edge in graph.leaving.get(name, ())
        if not edge.is_exhausted and loops.get(edge.target) == loops[name]
    )


def _ending(graph: Graph, spent: Collection[str]) -> set[str]:
    """Return the states from which an outcome can be reached when some have had their attempts.

    A target that does not exist may be an end, so only what is known to lead on is followed.
    """
    entering, known = graph.entering, set(graph.ids)
    found = {target for target in entering if target not in known}
    waiting = list(found)
    while waiting:
        for edge in entering.get(waiting.pop(), ()):
            leads_on = edge.source not in spent or edge.event == EXHAUSTED
            if leads_on and edge.source not in found:
                found.add(edge.source)
                waiting.append(edge.source)
    return found


def _led_to(start: str, graph: Graph, spent: Collection[str]) -> str:
    """Return the states that can be reached from one when some have had their attempts."""
    found = reachable(
        [start],
        lambda name: [
            edge.target
            for edge in graph.leaving.get(name, ())
            if edge.source not in spent or edge.event == EXHAUSTED
        ],
    )
    return names.quoted(other for other in graph.ids if other in found)


# Warn of loops that nothing bounds


def check_loops(resolved: ResolvedChart, graph: Graph) -> Iterator[Problem]:
    """Yield a warning for each knot of loops that no limit of attempts ends.

    A state whose attempts are spent still leads on, with `exhausted`.
    """
    by_id = resolved.by_id
    rest = graph.free
    # A knot that nothing leads out of is reported as an error.
    left = {
        rest.loops[edge.source]
        for edge in rest.edges
        if rest.loops[edge.source] != rest.loops.get(edge.target)
    }
    reported: set[int] = set()
    for name in by_id:
        loop = rest.loops.get(name)
        is_counted = by_id[name].node.attempts is not None
        if is_counted or name not in rest.looping or loop not in left or loop in reported:
            continue
        reported.add(loop)
        path = shortest_path(name, name, rest.leaving) or ()
        message = (
            f"nothing bounds the loop {path_text(path)}: while it fails, it continues forever. "
        )
        if any(edge.event == EXHAUSTED for edge in path):
            message += (
                f"Let '{EXHAUSTED}' lead out of it, or give another of its states ext:attempts."
            )
        else:
            message += "Give one of its states ext:attempts."
        yield Problem(by_id[name].node.position(), ProblemKind.UNBOUNDED_LOOP, message)
