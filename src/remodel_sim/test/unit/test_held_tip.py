"""InsertCable with an end that turned in the grip, in the cell of two heads."""

from dataclasses import replace
from pathlib import Path

import pytest
from place_wire import do, locate

from remodel_sim.abilities.detect_cable import detect_cable
from remodel_sim.abilities.insert_cable import insert_cable
from remodel_sim.abilities.pick_cable import pick_cable
from remodel_sim.abilities.primitives.pushing import FEEL_N
from remodel_sim.cell import Cell
from remodel_sim.core import goals
from remodel_sim.core.workpiece.panel import WireEnd
from remodel_sim.edge.cell_file import read_cell
from remodel_sim.edge.wire_material_file import read_wire_materials
from remodel_sim.physics.truth import ground_truth
from remodel_sim.ros.conversions import read_panel

CONFIG = Path(__file__).parents[2] / "config"
HOLDER, WIRE = "robot_2", "W8"


@pytest.mark.parametrize("above", [0.0045, -0.0055])
def test_a_tip_that_is_not_where_the_hand_holds_it_is_seen_and_brought_to_its_opening(
    pushes, above
):
    panel = read_panel(
        CONFIG / "household.yaml", read_wire_materials(CONFIG / "wire_materials.yaml")
    )
    cell = Cell(panel, design=read_cell("two_arms_cabinet"), seed=1)
    holder = cell.contexts[HOLDER]
    cell.feed(WIRE, "")
    do(cell, detect_cable, goals.DetectGoal(WIRE))
    key = panel.wire(WIRE).goes_to(WireEnd.A)
    socket = locate(cell, *key)
    cell.run(pick_cable(holder, goals.PickGoal(HOLDER, WIRE, WireEnd.A, 0.0)), HOLDER)
    grip = holder.belief.grip
    holder.belief.grip = replace(grip, height=grip.height - above)
    goal = goals.InsertGoal(HOLDER, WIRE, WireEnd.A, *key, socket, 14.0)
    cell.run(insert_cable(holder, goal), HOLDER)
    (truth,) = ground_truth(cell.plant, [WIRE])
    assert truth.a.seated
    limits = [push.limit for push in pushes]
    assert limits == [14.0, FEEL_N, 14.0, FEEL_N, 14.0], "the second push goes in"
    cell.close()
