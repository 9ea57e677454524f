"""The hand gives way to an opening whose end it pushes in askew."""

from pathlib import Path

import numpy as np
import pytest
from place_wire import do, insert

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills import goals
from remodel_skills.abilities.detect_cable import detect_cable
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.force_control import Yielding
from remodel_states.edge.wire_material_file import read_wire_materials
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.ros.panel_message import read_panel

MOTION = read_parameters().parameters.motion

CONFIG = Path(__file__).parents[2] / "config"
STEP_S = 1 / 240
WIRE = "W1.4"


def test_it_gives_way_against_the_force_no_faster_than_the_arm_speeds_up():
    yielding = Yielding(np.eye(3)[:2], np.array([0.001, 0.004]), stiffness=1e3)
    free = yielding.speeds(np.zeros(2), np.zeros(2), STEP_S, MOTION)
    pushed = yielding.speeds(np.array([-1.0, 0.01]), np.zeros(2), STEP_S, MOTION)
    np.testing.assert_allclose(free, 0.0)
    assert pushed[0] == pytest.approx(MOTION.force_acceleration_m_s2 * STEP_S)
    assert -MOTION.force_acceleration_m_s2 * STEP_S < pushed[1] < 0.0


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.parametrize("low_m", [0.0025, -0.0025])
def test_an_end_that_slim_fingers_hold_too_low_or_too_high_is_seated(low_m):
    panel = read_panel(CONFIG / "harness.yaml", read_wire_materials())
    cell = Cell(SimulatedPlant(panel, design=read_cell("two_arms_formboard"), seed=1))
    key = panel.wire(WIRE).goes_to(WireEnd.A)
    cell.feed(WIRE, "")
    do(cell, detect_cable, goals.DetectGoal(WIRE))
    socket = cell.plant.world_from_socket(*key)
    low = Pose(socket.position - np.array([0.0, 0.0, low_m]), socket.quaternion)
    insert(cell, WIRE, WireEnd.A, *key, low)
    (truth,) = ground_truth(cell.plant, [WIRE])
    assert truth.a.seated
    cell.close()
