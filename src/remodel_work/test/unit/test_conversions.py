"""What a panel's message says of rails, slotted ducts, screws and routes is in the panel."""

import pytest
from geometry_msgs.msg import Point, Pose2D
from panels import EXAMPLES, example
from remodel_msgs.msg import Component, Duct, Rail, Terminal, Wire
from remodel_msgs.msg import Panel as PanelMsg

from remodel_states.core.wires import PROPERTIES, WireMaterials
from remodel_work import panel as values
from remodel_work.ros.panel_message import panel_from, panel_message

MATERIAL = dict.fromkeys(PROPERTIES, 0.5)


def panel_of(**parts):
    return panel_from(PanelMsg(name="P", **parts), WireMaterials({}))


def test_rails_and_slotted_ducts_are_on_the_panel():
    rail = Rail(id="R1", pose=Pose2D(0.1, 0.2, 1.5), length=0.5, width=0.035, height=0.0075)
    duct = Duct(
        id="D1",
        pose=Pose2D(0.1, 0.2, 1.5),
        length=0.5,
        width=0.040,
        height=0.060,
        slot_pitch=0.0125,
        slot_width=0.0055,
        slot_bottom=0.015,
    )
    panel = panel_of(rails=[rail], ducts=[duct])
    assert panel.rails == (values.Rail("R1", (0.1, 0.2, 1.5), 0.5, 0.035, 0.0075),)
    assert panel.ducts == (
        values.Duct("D1", (0.1, 0.2, 1.5), 0.5, 0.040, 0.060, 0.0125, 0.0055, 0.015),
    )


def test_a_terminal_has_a_screw_only_where_the_message_says_its_place():
    clamps = [Terminal(id="1", screw=Point(0.03, 0.01, 0.045)), Terminal(id="2")]
    (component,) = panel_of(components=[Component(id="Q1", terminals=clamps)]).components
    assert [t.screw for t in component.terminals] == [(0.03, 0.01, 0.045), None]


def test_a_terminal_closes_by_itself_if_the_message_says_with_what_force():
    clamps = [Terminal(id="1", insertion_force=12.0), Terminal(id="2")]
    (component,) = panel_of(components=[Component(id="X1", terminals=clamps)]).components
    assert [t.closes_itself for t in component.terminals] == [True, False]


def test_a_wire_knows_its_route_its_ducts_and_where_it_is_presented():
    routed = Wire(
        id="W1",
        route=[Point(0.0, 0.1, 0.02), Point(0.1, 0.1, 0.03)],
        ducts=["D1", "L"],
        presented_at=Pose2D(-0.3, 0.1, 0.0),
        **MATERIAL,
    )
    first, second = panel_of(wires=[routed, Wire(id="W2", **MATERIAL)]).wires
    assert first.route == ((0.0, 0.1, 0.02), (0.1, 0.1, 0.03))
    assert (first.ducts, first.presented_at) == (("D1", "L"), (-0.3, 0.1, 0.0))
    assert (second.route, second.ducts, second.presented_at) == ((), (), None)


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.yaml")), ids=lambda file: file.stem)
def test_a_panel_that_is_written_is_read_again(file):
    panel = example(file.stem)
    assert panel_from(panel_message(panel), WireMaterials({})) == panel
