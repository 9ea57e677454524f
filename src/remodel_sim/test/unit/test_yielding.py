"""The hand gives way to an opening whose end it pushes in askew."""

import numpy as np
import pytest
from panels import example
from place_wire import do, insert

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.picking import DetectGoal, detect_cable
from remodel_skills.cell import Cell
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd

WIRE = "W1.4"


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.parametrize("low_m", [0.0025, -0.0025])
def test_an_end_that_slim_fingers_hold_too_low_or_too_high_is_seated(low_m):
    panel = example("harness")
    cell = Cell(SimulatedPlant(panel, design=read_cell("two_arms_formboard"), seed=1))
    key = panel.wire(WIRE).goes_to(WireEnd.A)
    cell.feed(WIRE, "")
    do(cell, detect_cable, DetectGoal(WIRE))
    socket = cell.plant.world_from_socket(*key)
    low = Pose(socket.position - np.array([0.0, 0.0, low_m]), socket.quaternion)
    insert(cell, WIRE, WireEnd.A, *key, low)
    (truth,) = ground_truth(cell.plant, [WIRE])
    assert truth.a.seated
    cell.close()
