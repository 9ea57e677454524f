"""Changes to the values of charts, to what runs at once, and to where failures lead."""

from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Connection, ContainerKind, ErrorRoute, Input, When
from remodel_console.core import chart_edit
from remodel_console.core.chart_edit import (
    kind_at,
    with_condition,
    with_input,
    with_kind,
    with_output,
)
from remodel_console.errors import CommandError

ERRAND = parse_chart((Path(__file__).parents[1] / "charts" / "errand.xml").read_bytes())


def names(ports):
    return [port.name for port in ports]


def test_a_value_that_is_taken_is_added_changed_and_removed():
    chart = with_input(ERRAND, 1, "count", "int", default="3")
    assert chart.inputs[1] == Input("count", "int", 3)
    chart = with_input(chart, 1, "count", "", default="")
    assert chart.inputs[1] == Input("count")
    assert with_input(chart, 1, "", "", default="") == ERRAND
    assert (
        parse_chart(write_chart(with_input(ERRAND, 1, "count", "int", default="3")))
        .inputs[1]
        .default
        == 3
    )


def test_the_default_of_a_string_is_its_text():
    assert with_input(ERRAND, 1, "code", "string", default="5").inputs[1] == Input(
        "code", "string", "5"
    )
    assert with_input(ERRAND, 1, "code", "string", default="'5'").inputs[1].default == "5"


def test_connections_follow_the_name_of_a_value():
    chart = with_input(ERRAND, 0, "words", "string", default="")
    assert chart.connections == (Connection("Errand", "words", "Greet", "data"),)
    assert with_input(ERRAND, 0, "", "", default="").connections == ()
    given = with_output(ERRAND, 0, "seen", "bool")
    fed = chart_edit.fed(given, "Errand", "seen", ("Greet", "data"))
    renamed = with_output(fed, 0, "found", "bool")
    assert chart_edit.feed_of(renamed, "Errand", "found") == ("Greet", "data")
    assert names(with_output(renamed, 0, "", "").outputs) == []


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("greeting", "", "already"),
        ("2nd", "", "no key"),
        ("_hidden", "", "no key"),
        ("count", "number", "'number' is no type"),
    ],
)
def test_a_value_that_cannot_be_is_refused(name, kind, words):
    with pytest.raises(CommandError, match=words):
        with_input(ERRAND, 1, name, kind, default="")


def test_what_runs_at_once_has_no_first_state_and_no_transitions():
    chart = with_kind(ERRAND, "Search", ContainerKind.CONCURRENCY)
    body = chart_edit.node_at(chart, ("Search",)).body
    assert kind_at(chart, ("Search",)) is ContainerKind.CONCURRENCY
    assert kind_at(chart, ()) is ContainerKind.SEQUENCE
    assert (body.initial, [node.transitions for node in body.nodes]) == ("", [(), ()])
    body = with_condition(body, 0, "found", (("Look", "done"), ("Look closer", "done")))
    assert body.conditions[0].all_of == (When("Look", "done"), When("Look closer", "done"))
    body = with_condition(body, 1, "found", (("Look", "done"),))
    assert len(body.conditions) == 2
    assert with_condition(body, 0, "", ()).conditions == body.conditions[1:]
    renamed = chart_edit.renamed(body, "Look", "Glance")
    assert renamed.conditions[0].all_of[0].state == "Glance"
    less = chart_edit.without_node(body, "Look")
    assert [c.all_of for c in less.conditions] == [(When("Look closer", "done"),)]


def test_back_to_one_after_another_begins_with_the_first():
    chart = with_kind(ERRAND, "Search", ContainerKind.CONCURRENCY)
    chart = with_kind(chart, "Search", ContainerKind.PRIORITY)
    assert chart_edit.node_at(chart, ("Search",)).body.initial == "Look"


def test_failures_are_led_by_their_codes_and_follow_names():
    chart = chart_edit.routed(ERRAND, "Greet", "100-199: Search; 305: failed")
    greet = chart_edit.node_at(chart, ("Greet",))
    assert greet.on_error == (ErrorRoute("100-199", "Search"), ErrorRoute("305", "failed"))
    chart = chart_edit.renamed(chart, "Search", "Hunt")
    assert chart_edit.node_at(chart, ("Greet",)).on_error[0].target == "Hunt"
    assert chart_edit.node_at(chart_edit.routed(chart, "Greet", ""), ("Greet",)).on_error == ()
    with pytest.raises(CommandError, match="'CODE: target'"):
        chart_edit.routed(ERRAND, "Greet", "very often: Search")
