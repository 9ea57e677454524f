"""Drawings for the page, and which part of them an active state is; no ROS."""

from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import Chart, Container, Outcome, State, Transition
from remodel_console.core.drawing import chart_graph, collapsed, drawn_path, drawn_paths, opened
from remodel_console.core.run_view import EngineStatus, RunView, step
from remodel_console.core.world import World, notices
from remodel_console.web.page import Page

ERRAND = parse_chart((Path(__file__).parents[1] / "charts" / "errand.xml").read_bytes())
OUTER = """<statemachine name="Outer" initial="Go"><datamodel><outcome name="finished"/></datamodel>
<behavior id="Go" type="Errand"><transition event="finished" target="finished"/>
<transition event="failed" target="finished"/></behavior></statemachine>"""


def test_a_graph_has_a_node_for_each_state_and_outcome_and_an_arrow_for_each_transition():
    graph = chart_graph(ERRAND)
    nodes = {node["id"]: node for node in graph["nodes"]}
    assert nodes["n:Search/Look closer"]["parent"] == "n:Search"
    assert nodes["n:Search"]["container"]
    assert nodes["o:failed"]["failure"]
    ends = {(edge["from"], edge["label"], edge["to"]): edge for edge in graph["edges"]}
    assert ("Search", "found", "Report") in ends
    assert ends["Report", "done · high", "finished"]["autonomy"] == "high"
    assert ends["Report", "exhausted", "failed"]["failure"]
    assert {edge[end] for edge in graph["edges"] for end in ("source", "target")} <= nodes.keys()


def test_a_graph_of_a_chart_with_errors_has_no_id_twice_and_no_arrow_to_nothing():
    led = (Transition("done", "gone"), Transition("failed", "A"))
    twice = (State("A", "WaitState", led), State("A", "WaitState"), State("end", "WaitState"))
    graph = chart_graph(Chart("Wrong", "lost", (Outcome("end"),), twice))
    ids = [node["id"] for node in graph["nodes"]]
    assert len(ids) == len(set(ids))
    missing = {node["name"] for node in graph["nodes"] if node["kind"] == "missing"}
    assert missing == {"gone", "lost"}
    assert {edge["target"] for edge in graph["edges"]} <= set(ids)


@pytest.mark.parametrize(
    ("engine", "drawn"),
    [
        ("/Greet", "Greet"),
        ("/Search/Look", "Search/Look"),
        ("/Report_attempts", "Report"),
        ("/Report/run", "Report"),
        ("/Search/Other", "Search"),
        ("/Nothing", ""),
        ("", ""),
    ],
)
def test_an_active_state_is_found_in_the_drawing(engine, drawn):
    assert drawn_path(engine, drawn_paths(ERRAND)) == drawn


def test_behaviors_inside_are_drawn_open():
    outer = parse_chart(OUTER.encode())
    inside = opened(outer, [ERRAND])
    assert isinstance(inside.nodes[0], Container)
    assert "Go/Search/Look" in drawn_paths(inside)
    assert opened(outer, []) == outer


def test_what_is_not_running_is_named_with_the_command_that_starts_it():
    assert [n.what for n in notices(World(), Page.PARTS)] == ["ROS is not running"]
    world = World(has_master=True)
    assert [n.what for n in notices(world, Page.PARTS)] == [
        "The engine is not running",
        "The cell is not running",
    ]
    world = World(step(RunView(), EngineStatus(20, 0)), has_master=True, servers=1)
    (mirror,) = notices(world, Page.PARTS)
    assert mirror.remedy == "roslaunch flexbe_mirror behavior_mirror.launch"


def test_a_large_chart_is_folded_but_for_the_path_of_interest():
    def box(name):
        inner = tuple(State(f"{name}{i}", "WaitState") for i in range(15))
        body = Chart(name, inner[0].id, (Outcome("through"),), inner)
        return Container(name, "container", (Transition("through", "B"),), body=body)

    small = Chart("Small", "A", nodes=(box("A"),))
    assert collapsed(small, ()) is small
    large = Chart("Large", "A", nodes=(box("A"), box("B"), box("C")))
    closed = collapsed(large, ())
    assert drawn_paths(closed) == {"A", "B", "C"}
    assert closed.nodes[0].type == "15 states inside"
    assert closed.nodes[0].transitions == large.nodes[0].transitions
    opened_one = collapsed(large, ("B",))
    assert "B/B3" in drawn_paths(opened_one)
    assert "A/A3" not in drawn_paths(opened_one)
    assert drawn_path("/A/A3", drawn_paths(opened_one)) == "A"
