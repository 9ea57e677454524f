import dataclasses

import pytest
from remodel_msgs.msg import Panel as PanelMsg
from remodel_msgs.msg import Wire as WireMsg

from remodel_sim.core.errors import MaterialError, PanelError
from remodel_sim.core.workpiece.wire_materials import PROPERTIES, materials_from
from remodel_sim.edge.wire_material_file import read_wire_materials
from remodel_sim.ros.conversions import panel_from

ROW = dict.fromkeys(PROPERTIES, 0.5)


def test_the_table_of_the_package_is_whole():
    soft = read_wire_materials().find("H07V-K", 1.5)
    assert soft.bending_stiffness == 1.0e-3
    assert read_wire_materials().find("", 0.75).diameter == 0.0026


def test_a_missing_material_is_named_with_what_there_is():
    with pytest.raises(MaterialError, match="no wire of any construction of 3 mm2; it has H05V-K"):
        read_wire_materials().find("", 3.0)


@pytest.mark.parametrize(
    ("parsed", "words"),
    [
        ([], r"the file is \[\]"),
        ({}, "it has no wire"),
        ({"K": {1.5: 3}}, "K 1.5 is 3"),
        ({"K": {"thin": ROW}}, "thin: section must be a number"),
        ({"K": {1.5: {**ROW, "colour": 1}}}, r"unknown \['colour'\]"),
        ({"K": {1.5: {"friction": 1}}}, "missing .*'diameter'"),
        ({"K": {1.5: {**ROW, "friction": "much"}}}, "K 1.5: friction must be a number"),
        ({"K": {1.5: {**ROW, "friction": -1.0}}}, "K 1.5: friction must be a number"),
    ],
)
def test_a_malformed_table_says_where(parsed, words):
    with pytest.raises(MaterialError, match=words):
        materials_from(parsed)


def test_a_table_that_cannot_be_read_names_its_file(tmp_path):
    with pytest.raises(MaterialError, match=r"none\.yaml"):
        read_wire_materials(tmp_path / "none.yaml")


def test_what_a_wire_leaves_unsaid_comes_from_the_table():
    materials = read_wire_materials()
    message = WireMsg(id="W", section=2.5, construction="H07V-K", friction=0.7, length=0.5)
    (wire,) = panel_from(PanelMsg(wires=[message]), materials).wires
    expected = dataclasses.asdict(materials.find("H07V-K", 2.5)) | {"friction": 0.7}
    assert {name: getattr(wire, name) for name in PROPERTIES} == expected


def test_every_wire_without_a_material_is_named():
    wires = [WireMsg(id="W1", section=3.0), WireMsg(id="W2", section=1.5, construction="H99")]
    with pytest.raises(PanelError) as caught:
        panel_from(PanelMsg(name="P", wires=wires), read_wire_materials())
    assert len(caught.value.problems) == 2
    assert "'W2'" in caught.value.problems[1]
