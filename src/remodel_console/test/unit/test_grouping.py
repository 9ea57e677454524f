"""States that are put into a container of their own."""

import pytest

from flexbe_synthesizer.core.chart.model import (
    Chart,
    Condition,
    Connection,
    Input,
    Outcome,
    Output,
    State,
    Transition,
    When,
)
from remodel_console.core.copying import grouped
from remodel_console.errors import CommandError


def state(name, *led, at=None):
    transitions = tuple(Transition(event, target) for event, target in led)
    return State(name, "S", transitions, at=at)


CHART = Chart(
    "Main",
    "A",
    (Outcome("finished"), Outcome("failed")),
    (
        state("A", ("done", "B")),
        state("B", ("done", "C"), ("failed", "failed"), at=(100, 50)),
        state("C", ("done", "D"), ("again", "B"), ("failed", "failed"), at=(80, 90)),
        state("D", ("done", "finished"), ("back", "B")),
    ),
    (Input("part"),),
    (Output("found"),),
    (
        Connection("A", "seen", "B", "seen"),
        Connection("B", "grip", "C", "grip"),
        Connection("B", "grip", "D", "grip"),
        Connection("B", "grip", "D", "other"),
    ),
)
READS = {"B": ("seen", "part"), "C": ("grip",)}
WRITES = {"B": ("grip",), "C": ("found",)}


def group(scope=CHART, ids=("B", "C"), reads=READS, writes=WRITES):
    return grouped(scope, ids, "Group", reads, writes)


def test_what_leads_in_and_out_goes_through_the_container():
    changed = group()
    assert [node.id for node in changed.nodes] == ["A", "Group", "D"]
    a, container, d = changed.nodes
    assert a.transitions == (Transition("done", "Group"),)
    assert d.transitions[1] == Transition("back", "Group")
    assert set(container.transitions) == {Transition("d", "D"), Transition("failed", "failed")}
    body = container.body
    assert body.initial == "B"
    assert {outcome.name for outcome in body.outcomes} == {"d", "failed"}
    assert body.nodes[1].transitions == (
        Transition("done", "d"), Transition("again", "B"), Transition("failed", "failed"),
    )  # fmt: skip
    assert changed.initial == "A"


def test_values_go_through_its_inputs_and_outputs():
    changed = group()
    body = changed.nodes[1].body
    assert [port.name for port in body.inputs] == ["seen", "part"]
    assert [port.name for port in body.outputs] == ["grip", "found"]
    assert set(body.connections) == {
        Connection("Group", "seen", "B", "seen"),
        Connection("B", "grip", "C", "grip"),
        Connection("B", "grip", "Group", "grip"),
    }
    assert set(changed.connections) == {
        Connection("A", "seen", "Group", "seen"),
        Connection("Group", "grip", "D", "grip"),
        Connection("Group", "grip", "D", "other"),
    }


def test_it_stands_where_its_states_stood():
    container = group().nodes[1]
    assert container.at == (80, 50)
    assert [node.at for node in container.body.nodes] == [(20, 0), (0, 40)]


def test_the_first_state_of_the_chart_makes_the_container_the_first():
    nodes = (state("A", ("done", "B")), state("B", ("done", "C")), state("C", ("done", "finished")))
    changed = group(Chart("Main", "A", CHART.outcomes, nodes), ("A", "B"), {}, {})
    container = changed.nodes[0]
    assert (changed.initial, container.body.initial, container.at) == ("Group", "A", None)


def test_a_group_that_is_entered_in_two_places_is_refused():
    nodes = (state("A", ("x", "C"), ("y", "D")), state("C", ("done", "D")), state("D"))
    with pytest.raises(CommandError, match="'C', 'D' are entered from outside"):
        grouped(Chart("Main", "A", CHART.outcomes, nodes), ("C", "D"), "Group", {}, {})


def test_states_that_run_at_once_are_not_grouped():
    at_once = Chart(
        "Both", "", (Outcome("finished"),), (state("A"), state("B")),
        conditions=(Condition("finished", (When("A", "done"),)),),
    )  # fmt: skip
    with pytest.raises(CommandError, match="run at once"):
        grouped(at_once, ("A",), "Group", {}, {})


def test_nothing_selected_is_refused():
    with pytest.raises(CommandError, match="select"):
        group(ids=())
