"""An arm on a linear axis: where the axis carries it, how it moves, what the cabinet reaches."""

import numpy as np
import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives.motions import move_to, park
from remodel_work.edge.cell_file import read_cell
from remodel_work.robot.arm import ToolPose

MOTION = read_parameters().parameters.motion
CELL, PAIR = read_cell("cabinet"), read_cell("two_arms_cabinet")
(ROBOT,) = CELL.robots
ARM = ROBOT.arm


@pytest.mark.physics
def test_the_simulated_arm_follows_with_its_axis_and_goes_home():
    cell = Cell(SimulatedPlant(panel(), design=read_cell("cabinet")))
    context, robot = cell.context, cell.plant.robots["robot_1"]
    target = ToolPose(0.60, 0.35, 0.10, 0.0)
    cell.run(move_to(context, target, MOTION.free_speed_m_s))
    np.testing.assert_allclose(robot.tool.position, target.position, atol=1e-3)
    names = dict(zip(robot.joint_names, robot.joint_state[0], strict=True))
    assert names["axis"] == pytest.approx(0.35, abs=0.02)
    base = robot.world_from_base.position
    np.testing.assert_allclose(base, [ARM.base[0], names["axis"], 0.0], atol=1e-6)
    cell.run(park(context))
    np.testing.assert_allclose(robot.tool.position, ROBOT.home.position, atol=1e-3)
    cell.close()
