"""Certificates: bounds held to what runs can reach, and what stands in the file."""

import hashlib
from itertools import pairwise

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from synthesizer_support.classes import COUNTER, state_class

from flexbe_synthesizer.core.chart.model import Chart, Outcome, Param, State, Transition
from flexbe_synthesizer.core.chart.problem import ProblemKind, errors_in
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.export.certificate import (
    certify,
    most_visits,
    read_chart_place,
    write_certificate,
)
from flexbe_synthesizer.core.library.signature import Library, Parameter

LIBRARY = Library(states=(state_class("Pass", ("a", "b")), COUNTER))
IDS = ("N0", "N1", "N2", "N3", "N4")


@st.composite
def charts(draw):
    """Draw a chart of five states, some counted."""
    targets = st.sampled_from((*IDS, "end"))
    nodes = []
    for node_id in IDS:
        events, limits = ["a", "b"], {}
        if draw(st.booleans()):
            events, limits = [*events, "exhausted"], {"attempts": draw(st.integers(1, 3))}
        transitions = tuple(Transition(event, draw(targets)) for event in events)
        nodes.append(State(node_id, "Pass", transitions, **limits))
    return Chart("Task", "N0", (Outcome("end"),), tuple(nodes))


def places(drawn):
    """Return what follows each (state, executions of counted states) that a run can reach."""
    by_id = {node.id: node for node in drawn.nodes}
    after, waiting = {}, [("N0", ())]
    while waiting:
        place = waiting.pop()
        if place in after:
            continue
        name, counts = place
        after[place] = []
        if name not in by_id:
            continue
        targets = {t.event: t.target for t in by_id[name].transitions}
        count = dict(counts).get(name, 0)
        if by_id[name].attempts == count:
            after[place] = [(False, (targets["exhausted"], counts))]
        else:
            if by_id[name].attempts is not None:
                counts = tuple(sorted({**dict(counts), name: count + 1}.items()))
            after[place] = [(True, (targets[event], counts)) for event in ("a", "b")]
        waiting += [following for _runs, following in after[place]]
    return after


def reached_visits(drawn):
    """Return how often each state runs in the longest of all runs, None if there is none."""
    after = places(drawn)
    found = {}
    for name in IDS:
        longest = dict.fromkeys(after, 0)
        for _round in range(len(after) + 1):
            changed = False
            for place, steps in after.items():
                best = max((longest[n] + (r and place[0] == name) for r, n in steps), default=0)
                changed |= best != longest[place]
                longest[place] = best
            if not changed:
                break
        found[name] = None if changed else longest["N0", ()]
    return found


def test_no_run_visits_a_state_more_often_than_its_bound_and_most_bounds_are_reached():
    is_reached = []

    @given(charts())
    @settings(max_examples=150, derandomize=True)  # a share needs a fixed sample
    def compare(drawn):
        resolved = check_chart(drawn, LIBRARY, {}).resolved
        bounds = most_visits(resolved, 1)
        for name, most in reached_visits(drawn).items():
            bound = bounds[name]
            assert bound is None or (most is not None and most <= bound), (name, bound, most)
            is_reached.append(bound == most)

    compare()
    assert sum(is_reached) > 0.8 * len(is_reached)


def test_a_loop_that_goes_on_with_attempts_spent_is_warned_of():
    nodes = (
        State("N0", "Pass", tuple(map(Transition, "ab", ("end", "N1")))),
        State(
            "N1", "Pass",
            tuple(map(Transition, ("a", "b", "exhausted"), ("end", "N0", "N0"))), attempts=2,
        ),
    )  # fmt: skip
    chart = Chart("Task", "N0", (Outcome("end"),), nodes)
    (problem,) = check_chart(chart, LIBRARY, {}).problems
    assert problem.code is ProblemKind.UNBOUNDED_LOOP
    assert "N0 -b-> N1 -exhausted-> N0" in problem.message


@pytest.fixture
def certificate(check):
    """Return a function: chart text -> its certificate as it is read from the file."""

    def certificate(text):
        checked, problems = check(text)
        assert errors_in(problems) == ()
        code = hashlib.sha256(b"code").hexdigest()
        return yaml.safe_load(
            write_certificate(certify(checked, "p"), "charts/a.xml", code, ["INIT"])
        )

    return certificate


@pytest.mark.parametrize("place", ["charts/a.xml", '../other/"Ä" b.xml'])
def test_the_chart_of_a_certificate_is_read_back(check, golden, place):
    checked, _problems = check((golden / "charts" / "plain.xml").read_text())
    assert read_chart_place(write_certificate(certify(checked, "p"), place, "")) == place


@pytest.mark.parametrize("text", ["", "behavior: x\n", "chart: 3\n", "chart: [\n"])
def test_a_certificate_without_a_chart_has_none(text):
    assert read_chart_place(text) is None


def rows(found, part):
    return {row["path"]: row for row in found[part]}


def test_the_certificate_of_a_golden_chart_says_what_its_chart_bounds(golden, certificate):
    found = certificate((golden / "charts" / "place_connector.xml").read_text())
    assert (found["behavior"], found["package"], found["manual_code"]) == (
        "Place Connector",
        "p",
        ["INIT"],
    )
    locate = rows(found, "states")["Locate"]
    assert (locate["visits"], locate["visit_s"], locate["longest_s"]) == (3, 5.0, 15.0)
    assert rows(found, "states")["Fix"]["visit_s"] == 12.5  # by the timer beside it
    assert found["longest_s"] == sum(row["longest_s"] for row in found["states"])


TIMEOUT = Parameter("timeout_s", "float", required=False, default=5.0, grace_s=2.0)
LIMITED = state_class("Limited", ("done",), parameters=(TIMEOUT,))


@pytest.mark.parametrize(
    ("limit", "visit_s"),
    [({}, 7.0), ({"timeout_s": 3.0}, 5.0), ({"params": (Param("timeout_s", 4.0),)}, 6.0)],
)
def test_a_visit_may_last_as_long_as_its_class_allows_beyond_the_limit(limit, visit_s):
    node = State("N0", "Limited", (Transition("done", "end"),), **limit)
    checked = check_chart(
        Chart("Task", "N0", (Outcome("end"),), (node,)), Library(states=(LIMITED,)), {}
    )
    assert errors_in(checked.problems) == ()
    found = certify(checked, "p")
    assert (found.states[0].visit_s, found.longest_s) == (visit_s, visit_s)


CONTAINER = """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Task" initial="Box">
  <datamodel><outcome name="fine"/><outcome name="bad"/><output name="error_code"/></datamodel>
  <ext:container id="Box" initial="Try" ext:attempts="4"><datamodel>
    <outcome name="in"/><outcome name="out"/><output name="error_code"/></datamodel>
    <state id="Try" type="TryState" ext:timeout_s="2" ext:on_error="7: in; 3-5: in">
      <transition event="done" target="in"/><transition event="given up" target="Again"/>
      <transition event="failed" target="out"/><transition event="timed_out" target="in"/></state>
    <state id="Again" type="TryState" ext:attempts="3">
      <transition event="done" target="in"/><transition event="given up" target="Try"/>
      <transition event="failed" target="out"/><transition event="exhausted" target="out"/></state>
    <transition event="in" target="fine"/><transition event="out" target="Box"/>
    <transition event="exhausted" target="bad"/></ext:container></statemachine>"""


def test_inside_a_container_bounds_and_ends_are_those_of_the_whole_behavior(certificate):
    found = certificate(CONTAINER)
    states = rows(found, "states")
    assert states["Box"]["visits"] == 4
    assert states["Box/Try"] == {"path": "Box/Try", "visits": 7, "visit_s": 2.0, "longest_s": 14.0}
    assert states["Box/Again"]["visits"] == 3
    assert (states["Box/Again"]["visit_s"], found["longest_s"]) == ("unbounded", "unbounded")
    ends = {(e["path"], e["event"], e["codes"]): (e["next"], e["ends"]) for e in found["errors"]}
    assert ends == {
        ("Box/Try", "failed", "7, 3-5"): ("in", ["fine"]),
        ("Box/Try", "failed", "other"): ("out", ["bad", "fine"]),
        ("Box/Again", "failed", "any"): ("out", ["bad", "fine"]),
        ("Box", "in", "any"): ("fine", ["fine"]),
        ("Box", "out", "any"): ("Box", ["bad", "fine"]),
    }
    assert found["outcomes"] == [
        {"outcome": "fine", "always": [], "sometimes": ["error_code"]},
        {"outcome": "bad", "always": [], "sometimes": ["error_code"]},
    ]


@pytest.mark.parametrize(("visit_s", "longest_s"), [(1e-5, 7e-5), (1e308, "unbounded")])
def test_a_time_is_a_number_or_too_long_for_one(certificate, visit_s, longest_s):
    timed = CONTAINER.replace('ext:timeout_s="2"', f'ext:timeout_s="{visit_s}"')
    bound = rows(certificate(timed), "states")["Box/Try"]
    assert (bound["visit_s"], bound["longest_s"]) == (visit_s, pytest.approx(longest_s))


def test_what_is_only_assumed_of_state_classes_is_listed(certificate, golden):
    found = certificate((golden / "charts" / "place_connector.xml").read_text())
    assert "cell_states/InsertCableState" in found["assumed"]
    assert all(a < b for a, b in pairwise(found["assumed"]))
    assert certificate(CONTAINER)["assumed"] == []  # TryState declares what it writes
