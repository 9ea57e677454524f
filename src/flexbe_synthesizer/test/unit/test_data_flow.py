"""Homes of values, and reads before writes held against a reference that walks all paths."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from synthesizer_support.classes import COUNTER, state_class

from flexbe_synthesizer.core.chart.model import (
    Chart,
    Connection,
    Input,
    Outcome,
    Output,
    State,
    Transition,
)
from flexbe_synthesizer.core.chart.problem import ProblemKind
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.library.signature import Effect, Library, Parameter

EMPTY = frozenset()
LIBRARY = Library(
    states=(
        COUNTER,
        state_class("Write", ("a", "b"), outputs=["v"]),
        state_class("Half", ("a", "b"), outputs=["v"], effects=(Effect("b", EMPTY, EMPTY),)),
        state_class("Read", ("a", "b"), inputs=["v"]),
        state_class("Pass", ("a", "b")),
        state_class("Late", ("a", "timed_out", "exhausted"), outputs=["v"]),
        state_class("Change", ("a", "b"), inputs=["v"], outputs=["v"]),
        state_class("WaitState", ("done",), (), (), "flexbe_states", (Parameter("wait_time"),)),
    )
)


def chart(nodes, connections=(), inputs=(), outputs=()):
    return Chart(
        "Task",
        nodes[0].id,
        outcomes=(Outcome("end"),),
        nodes=tuple(nodes),
        inputs=tuple(map(Input, inputs)),
        outputs=tuple(map(Output, outputs)),
        connections=tuple(Connection(*c) for c in connections),
    )


def state(node_id, kind, a="end", b="end", exhausted="end", **limits):
    transitions = [Transition("a", a), Transition("b", b)]
    if "attempts" in limits:
        transitions.append(Transition("exhausted", exhausted))
    if "timeout_s" in limits:
        transitions.append(Transition("timed_out", "end"))
    return State(node_id, kind, tuple(transitions), **limits)


def checked(*arguments, **parts):
    return check_chart(chart(*arguments, **parts), LIBRARY, {})


def flat(homes):
    return {(node, name): home for node, own in homes.items() for name, home in own.items()}


def codes(result):
    return [problem.code for problem in result.problems]


def test_a_value_that_stays_inside_is_named_by_who_writes_it():
    nodes = [state("LookAt", "Write", "Use"), state("Use", "Read")]
    result = checked(nodes, [("LookAt", "v", "Use", "v")])
    assert codes(result) == []
    assert flat(result.resolved.flow.outputs) == {("LookAt", "v"): "look_at_v"}
    assert flat(result.resolved.flow.inputs) == {("Use", "v"): "look_at_v"}


def test_homes_never_collide():
    nodes = [state("A b", "Write", "A-b"), state("A-b", "Write", "C"), state("C", "Read")]
    result = checked(nodes, [("A b", "v", "C", "v")], inputs=["a_b_v_2"])
    assert set(flat(result.resolved.flow.outputs).values()) == {"a_b_v", "a_b_v_3"}


def test_a_machine_input_feeds_by_its_name_unless_a_connection_says_otherwise():
    nodes = [state("A", "Write", "B"), state("B", "Read", "C"), state("C", "Read", "D")]
    nodes.append(state("D", "Read"))
    result = checked(nodes, [("A", "v", "B", "v"), ("Task", "w", "D", "v")], inputs=["v", "w"])
    assert [result.resolved.flow.inputs[n]["v"] for n in "BCD"] == ["a_v", "v", "w"]


def test_a_machine_output_is_fed_by_name_unless_a_connection_says_otherwise():
    nodes = [state("A", "Write", "B"), state("B", "Write")]
    result = checked(nodes, outputs=["v"])
    assert set(flat(result.resolved.flow.outputs).values()) == {"v"}
    result = checked(nodes, [("B", "v", "Task", "v")], outputs=["v"])
    assert flat(result.resolved.flow.outputs) == {("A", "v"): "a_v", ("B", "v"): "v"}


def test_a_value_that_is_read_and_written_stays_where_it_is_read():
    nodes = [state("A", "Write", "B"), state("B", "Change", "B")]
    result = checked(nodes, [("A", "v", "B", "v")])
    assert flat(result.resolved.flow.outputs) == {("A", "v"): "a_v", ("B", "v"): "a_v"}
    assert codes(result) == [ProblemKind.UNBOUNDED_LOOP]


def test_an_input_and_an_output_of_the_chart_with_one_name_are_one_value():
    result = checked([state("A", "Change", "A")], inputs=["v"], outputs=["v"])
    assert codes(result) == [ProblemKind.UNBOUNDED_LOOP]
    assert (
        flat(result.resolved.flow.outputs) == flat(result.resolved.flow.inputs) == {("A", "v"): "v"}
    )


def test_an_input_can_go_straight_to_an_output_of_its_name():
    result = checked([state("A", "Pass")], [("Task", "v", "Task", "v")], ["v"], ["v"])
    assert codes(result) == []


def test_a_value_that_is_read_and_written_cannot_have_a_second_home():
    nodes = [state("A", "Write", "B"), state("B", "Change")]
    result = checked(nodes, [("A", "v", "B", "v"), ("B", "v", "Task", "w")], outputs=["w"])
    assert codes(result) == [ProblemKind.CONFLICTING_OUTPUT]


def test_an_output_that_lives_elsewhere_cannot_feed_the_output_of_its_name():
    nodes = [state("A", "Write", "B"), state("B", "Write")]
    result = checked(nodes, [("A", "v", "Task", "w")], outputs=["v", "w"])
    assert codes(result) == [ProblemKind.CONFLICTING_OUTPUT]
    assert "output 'v' of state 'A' lives in 'w'" in result.problems[0].message
    flows = [("A", "v", "Task", "w"), ("B", "v", "Task", "v")]
    assert codes(checked(nodes, flows, outputs=["v", "w"])) == []

    nodes = [state("A", "Change", "B"), state("B", "Write")]
    result = checked(nodes, [("Task", "n", "A", "v")], inputs=["n"], outputs=["v"])
    assert codes(result) == [ProblemKind.CONFLICTING_OUTPUT]
    result = checked(nodes[:1], [("Task", "n", "A", "v")], inputs=["n"], outputs=["v"])
    assert ProblemKind.CONFLICTING_OUTPUT in codes(result)
    assert ProblemKind.UNFED_OUTPUT not in codes(result)


def test_states_that_change_each_others_values_in_a_circle_are_bound_all_the_same():
    nodes = [state("A", "Change", "B"), state("B", "Change", "A")]
    result = checked(nodes, [("A", "v", "B", "v"), ("B", "v", "A", "v")])
    assert ProblemKind.READ_BEFORE_WRITE in codes(result)
    assert len(set(flat(result.resolved.flow.outputs).values())) == 1


def test_what_a_state_before_its_last_attempt_has_written_can_be_read_when_it_is_exhausted():
    nodes = [
        state("A", "Pass", "W", exhausted="R", attempts=2),
        state("W", "Write", "A"),
        state("R", "Read"),
    ]
    assert codes(checked(nodes, [("W", "v", "R", "v")])) == []
    nodes[0] = state("A", "Pass", "W", "A", exhausted="R", attempts=2)
    result = checked(nodes, [("W", "v", "R", "v")])
    assert codes(result) == [ProblemKind.READ_BEFORE_WRITE]
    assert "A -b-> A -exhausted-> R" in result.problems[0].message


def test_a_state_that_a_timer_ends_has_written_nothing():
    nodes = [state("W", "Write", "R", "R", timeout_s=2.0), state("R", "Read")]
    assert codes(checked(nodes, [("W", "v", "R", "v")])) == []
    late = State(
        "W",
        "Write",
        (Transition("a", "R"), Transition("b", "R"), Transition("timed_out", "R")),
        timeout_s=2.0,
    )
    result = checked([late, nodes[1]], [("W", "v", "R", "v")])
    assert codes(result) == [ProblemKind.READ_BEFORE_WRITE]
    assert "W -timed_out-> R" in result.problems[0].message


def test_an_event_that_the_extension_and_the_class_both_have_is_one_and_proves_nothing():
    transitions = tuple(Transition(event, "R") for event in ("a", "timed_out", "exhausted"))
    reader = state("R", "Read")
    flows = [("L", "v", "R", "v")]
    assert codes(checked([State("L", "Late", transitions), reader], flows)) == []
    for limits in ({"timeout_s": 2.0}, {"attempts": 2}):
        result = checked([State("L", "Late", transitions, **limits), reader], flows)
        assert codes(result) == [ProblemKind.READ_BEFORE_WRITE]


WRITERS = ("Write", "Half")
IDS = ("N0", "N1", "N2", "N3", "N4")


@st.composite
def charts(draw, ends=("end",)):
    """Draw a chart of five states, some counted, in which each reader reads one writer."""
    kinds = draw(st.lists(st.sampled_from([*WRITERS, "Read", "Pass"]), min_size=5, max_size=5))
    targets = st.sampled_from((*IDS, *ends))
    nodes = []
    for node_id, kind in zip(IDS, kinds, strict=True):
        limits = {"attempts": draw(st.integers(1, 2))} if draw(st.booleans()) else {}
        nodes.append(
            state(node_id, kind, draw(targets), draw(targets), exhausted=draw(targets), **limits)
        )
    writers = [n.id for n in nodes if n.type in WRITERS]
    readers = [n.id for n in nodes if n.type == "Read"]
    connections = [(draw(st.sampled_from(writers)), "v", r, "v") for r in readers if writers]
    return chart(nodes, connections)


def walk(drawn):
    """Yield (state or outcome, who wrote so far, in order) for each way to each of them."""
    by_id = {node.id: node for node in drawn.nodes}
    seen = set()
    waiting = [(drawn.initial, (), frozenset())]
    while waiting:
        step = waiting.pop()
        if step in seen:
            continue
        seen.add(step)
        node_id, written, visits = step
        if node_id not in by_id:
            yield node_id, written
            continue
        node = by_id[node_id]
        targets = {t.event: t.target for t in node.transitions}
        count = dict(visits).get(node_id, 0) + 1
        if node.attempts is not None and count > node.attempts:
            waiting.append((targets["exhausted"], written, visits))
            continue
        yield node_id, written
        if node.attempts is not None:
            visits = frozenset({**dict(visits), node_id: count}.items())
        for event in ("a", "b"):
            now = written
            if node.type == "Write" or (node.type == "Half" and event == "a"):
                now = (*(other for other in written if other != node_id), node_id)
            waiting.append((targets[event], now, visits))


def sources(drawn):
    return {c.input_state_id: c.output_state_id for c in drawn.connections}


def reported(problems, code):
    """Return the states that problems of one code are about."""
    about = (
        p.message.partition("state '")[2].partition("'")[0] for p in problems if p.code is code
    )
    return set(about)


def uncounted(drawn, outputs=()):
    """Return the chart without limits of attempts."""
    nodes = tuple(
        State(n.id, n.type, tuple(t for t in n.transitions if t.event != "exhausted"))
        for n in drawn.nodes
    )
    return chart(nodes, [(w, "v", r, "v") for r, w in sources(drawn).items()], outputs=outputs)


@given(charts())
def test_every_read_that_some_path_makes_too_early_is_found(drawn):
    source = sources(drawn)
    early = {n for n, written in walk(drawn) if n in source and source[n] not in written}
    problems = check_chart(drawn, LIBRARY, {}).problems
    assert early <= reported(problems, ProblemKind.READ_BEFORE_WRITE)


@given(charts().map(uncounted))
def test_without_counted_states_nothing_else_is_reported(drawn):
    source = sources(drawn)
    early = {n for n, written in walk(drawn) if n in source and source[n] not in written}
    problems = check_chart(drawn, LIBRARY, {}).problems
    assert early == reported(problems, ProblemKind.READ_BEFORE_WRITE)


@given(charts().map(lambda drawn: uncounted(drawn, outputs=["v"])))
def test_a_read_of_another_states_value_is_found_and_nothing_else(drawn):
    source = sources(drawn)
    steps = [(n, written) for n, written in walk(drawn) if n in source]
    early = {n for n, written in steps if not written}
    foreign = {n for n, written in steps if written and written[-1] != source[n]}
    problems = check_chart(drawn, LIBRARY, {}).problems
    assert early == reported(problems, ProblemKind.READ_BEFORE_WRITE)
    assert foreign - early == reported(problems, ProblemKind.OVERWRITTEN_VALUE)


@given(charts(ends=("end", "other")).map(lambda c: uncounted(c, outputs=["v"])))
def test_what_each_outcome_writes_is_what_some_and_what_all_paths_to_it_write(drawn):
    drawn = replace(drawn, outcomes=(Outcome("end"), Outcome("other")))
    resolved = check_chart(drawn, LIBRARY, {}).resolved
    effects = {effect.outcome: effect for effect in resolved.effects}
    ways = {}
    for node_id, written in walk(drawn):
        if node_id in effects:
            ways.setdefault(node_id, set()).add(bool(written))
    for outcome, effect in effects.items():
        assert (effect.certain, effect.possible) == (
            frozenset("v" if False not in ways.get(outcome, ()) else ""),
            frozenset("v" if True in ways.get(outcome, ()) else ""),
        )


def test_a_long_path_is_shortened_to_its_beginning_and_its_end():
    nodes = [state(f"A{index}", "Pass", f"A{index + 1}") for index in range(40)]
    nodes += [state("A40", "Read", "W"), state("W", "Write")]
    (problem,) = checked(nodes, [("W", "v", "A40", "v")]).problems
    assert problem.code is ProblemKind.READ_BEFORE_WRITE
    assert "A0 -a-> A1 " in problem.message
    assert " ... 20 more ... -a-> A31 " in problem.message
    assert "-a-> A40." in problem.message
