import dataclasses
import logging

import pytest
from remodel_msgs.msg import Panel as PanelMsg
from remodel_msgs.msg import Wire as WireMsg

from remodel_states.core.wires import PROPERTIES
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.errors import PanelError
from remodel_work.ros.panel_message import panel_from


def test_what_a_wire_leaves_unsaid_comes_from_the_table():
    materials = read_wire_materials()
    message = WireMsg(id="W", section=2.5, construction="H07V-K", friction=0.7, length=0.5)
    (wire,) = panel_from(PanelMsg(wires=[message]), materials).wires
    expected = dataclasses.asdict(materials.find("H07V-K", 2.5)) | {"friction": 0.7}
    assert {name: getattr(wire, name) for name in PROPERTIES} == expected


def test_the_cell_logs_which_wires_have_calculated_properties(caplog):
    wires = [WireMsg(id=f"W{n}", section=section) for n, section in enumerate((2.08, 1.5, 2.08))]
    with caplog.at_level(logging.INFO, logger="rosout"):
        panel = panel_from(PanelMsg(name="P", wires=wires), read_wire_materials())
    assert 0.0031 < panel.wires[0].diameter < 0.0037
    (line,) = caplog.messages
    assert line == (
        "panel 'P': properties of wires of 2.08 mm2 calculated between H07V-K 1.5 mm2 and H07V-K "
        "2.5 mm2, for 2 wires, such as W0"
    )


def test_every_wire_without_a_material_is_named():
    wires = [WireMsg(id="W1", section=16.0), WireMsg(id="W2", section=1.5, construction="H99")]
    with pytest.raises(PanelError) as caught:
        panel_from(PanelMsg(name="P", wires=wires), read_wire_materials())
    assert len(caught.value.problems) == 2
    assert "'W2'" in caught.value.problems[1]
