"""The chart of a wire's task."""

import math
from pathlib import Path

import pytest

from flexbe_synthesizer.core.codec import parse_chart, write_chart
from remodel_planner.core.panel_layout import PanelRules, lay_out
from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.wire_chart import BEYOND_M, LAY_DOWN, behavior_name, wire_chart
from remodel_planner.edge.catalogue_file import read_catalogue

CATALOGUE = read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml")
ORDER = Order(
    "t",
    "",
    "",
    (
        Component("Q1", "", (Terminal("B1", Side.BOTTOM),)),
        Component("Q2", "", (Terminal("T1", Side.TOP),)),
    ),
    (Wire("W1", TerminalRef("Q1", "B1"), TerminalRef("Q2", "T1"), "BU", 1.5, "line 1"),),
)
LAYOUT = lay_out(ORDER, CATALOGUE, PanelRules())
CHART = wire_chart(LAYOUT.wires[0], LAYOUT)


def test_the_chart_survives_its_file():
    assert parse_chart(write_chart(CHART), "wire.xml") == CHART


def test_equal_wires_make_equal_charts():
    assert write_chart(wire_chart(LAYOUT.wires[0], LAYOUT)) == write_chart(CHART)


def test_the_chart_carries_the_wire_in_its_inputs():
    defaults = {port.name: port.default for port in CHART.inputs}
    assert CHART.name == behavior_name("W1")
    assert defaults["cable_id"] == "W1"
    ends = {(defaults[f"{end}_component"], defaults[f"{end}_terminal"]) for end in "ab"}
    assert ends == {("Q1", "B1"), ("Q2", "T1")}


def test_the_end_is_routed_along_the_channel_to_its_terminal():
    (route,) = [node for node in CHART.nodes if node.id == "Route b"]
    ((x, y, z, yaw),) = route.params[0].value
    assert x == LAYOUT.channels[0].x
    assert abs(y - LAYOUT.wires[0].second_y) == pytest.approx(BEYOND_M)
    assert z > 0
    assert abs(math.sin(yaw)) == pytest.approx(1.0)


def test_whatever_is_given_up_with_a_wire_in_the_hand_ends_in_laying_it_down():
    nodes = {node.id: {t.event: t.target for t in node.transitions} for node in CHART.nodes}
    for giving_up in (
        nodes["Connect a"]["failed"],
        nodes["Pick b"]["command_error"],
        nodes["Route b"]["command_error"],
        nodes["Connect b"]["failed"],
    ):
        assert giving_up == LAY_DOWN
    assert set(nodes[LAY_DOWN].values()) == {"failed"}
