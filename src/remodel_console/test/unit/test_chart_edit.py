"""What a person changes in a chart keeps together what belongs together; no ROS."""

from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import State
from remodel_console.core import chart_edit
from remodel_console.core.editing import change_at
from remodel_console.errors import CommandError

CHARTS = Path(__file__).parents[1] / "charts"
ERRAND = parse_chart((CHARTS / "errand.xml").read_bytes())


def node(chart, *path):
    return chart_edit.node_at(chart, path)


def test_nodes_are_found_by_path():
    assert node(ERRAND, "Search", "Look").id == "Look"
    assert node(ERRAND, "Search", "finished") is None
    assert node(ERRAND, "Nowhere", "Look") is None
    assert node(ERRAND) is None


def test_a_new_chart_starts_at_what_is_added_first():
    chart = chart_edit.new_chart("New", "/charts/new.xml")
    chart = chart_edit.with_node(chart, State("A", "WaitState"))
    chart = chart_edit.with_node(chart, chart_edit.new_container("B"))
    assert (chart.initial, [n.id for n in chart.nodes]) == ("A", ["A", "B"])
    assert chart_edit.unused_id(chart, "A") == "A 2"
    assert chart_edit.unused_id(chart, "finished") == "finished 2"
    assert list(chart_edit.targets(chart)) == ["A", "B", "finished", "failed"]


def test_a_name_is_followed_by_all_that_use_it():
    chart = chart_edit.renamed(ERRAND, "Greet", "Say hello")
    assert chart.initial == "Say hello"
    assert chart.connections[0].input_state_id == "Say hello"
    chart = chart_edit.renamed(chart, "Search", "Hunt")
    assert node(chart, "Say hello").transitions[0].target == "Hunt"
    assert node(chart, "Hunt").body.name == "Hunt"
    assert chart_edit.renamed(chart, "Hunt", "Hunt") == chart
    assert parse_chart(write_chart(chart)) == chart


@pytest.mark.parametrize(
    ("name", "reason"), [("Report", "already"), ("failed", "already"), ("1 <x>", "no name")]
)
def test_a_name_that_cannot_be_used_is_refused(name, reason):
    with pytest.raises(CommandError, match=reason):
        chart_edit.renamed(ERRAND, "Greet", name)


def test_what_is_deleted_leaves_nothing_behind():
    chart = chart_edit.without_node(ERRAND, "Greet")
    assert (chart.initial, chart.connections) == ("Search", ())
    chart = chart_edit.without_node(ERRAND, "Search")
    assert node(chart, "Greet").transitions == ()


def test_outcomes_lead_where_they_are_led_and_keep_their_autonomy():
    chart = chart_edit.led(ERRAND, "Report", "done", "failed")
    assert node(chart, "Report").transitions[0].target == "failed"
    assert node(chart, "Report").transitions[0].autonomy is not None
    chart = chart_edit.led(chart, "Report", "done", "")
    assert [t.event for t in node(chart, "Report").transitions] == ["exhausted"]
    chart = chart_edit.led(chart, "Report", "done", "finished")
    assert node(chart, "Report").transitions[-1].target == "finished"


def test_parameters_are_literals_and_empty_ones_are_not_given():
    def change(scope):
        return chart_edit.with_parameter(scope, "Look", "wait_time", "0.5")

    chart = change_at(ERRAND, ("Search",), change)
    assert node(chart, "Search", "Look").params[0].value == 0.5
    chart = chart_edit.with_parameter(ERRAND, "Greet", "text", "__import__('os')")
    assert node(chart, "Greet").params[0].value == "__import__('os')"
    assert node(chart_edit.with_parameter(chart, "Greet", "text", ""), "Greet").params == ()


def test_data_is_fed_by_one_source():
    chart = chart_edit.fed(ERRAND, "Greet", "data", None)
    assert chart_edit.feed_of(chart, "Greet", "data") is None
    chart = chart_edit.fed(chart, "Greet", "data", ("Errand", "greeting"))
    assert chart == ERRAND
    assert chart_edit.feed_of(chart, "Greet", "data") == ("Errand", "greeting")


def test_limits_start_and_outcomes():
    chart = chart_edit.limited(ERRAND, "Greet", 2, 1.5)
    assert (node(chart, "Greet").attempts, node(chart, "Greet").timeout_s) == (2, 1.5)
    assert chart_edit.started_at(ERRAND, "Search").initial == "Search"
    chart = chart_edit.with_outcomes(ERRAND, ("finished", "late"))
    assert [outcome.name for outcome in chart.outcomes] == ["finished", "late"]
    assert [t.event for t in node(chart, "Report").transitions] == ["done"]
