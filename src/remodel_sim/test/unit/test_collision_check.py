"""Motions that would touch what stands on the plate, found before anything moves."""

import numpy as np
import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives.motions import move_to
from remodel_work.edge.cell_file import read_cell
from remodel_work.robot.arm import ToolPose

MOTION = read_parameters().parameters.motion
DESIGN = read_cell("cabinet")


@pytest.fixture(scope="module")
def cell():
    made = Cell(SimulatedPlant(panel(), design=DESIGN))
    yield made
    made.close()


def at(x, y, z, yaw=0.0):
    return ToolPose(x, y, z, yaw)


def beside_x2(side):
    """Return a tool pose low beside component X2: -1 in the channel, +1 beyond its row."""
    return at(0.58 + side * 0.055, 0.12, 0.03)


def travel(cell, target, **changes):
    """Move and return the heights of the tool on the way."""
    heights, context = [], cell.context

    def steps():
        for _ in move_to(context, target, MOTION.free_speed_m_s, **changes):
            heights.append(context.commanded.z)
            yield

    cell.run(steps())
    return heights


@pytest.mark.physics
def test_a_blocked_line_leads_over_the_obstacle(cell):
    travel(cell, beside_x2(-1).at(z=0.12))
    travel(cell, beside_x2(-1))
    heights = travel(cell, beside_x2(1))
    assert max(heights) == pytest.approx(MOTION.lifts_z_m[0], abs=1e-6)
    np.testing.assert_allclose(
        cell.context.device.arm.tool.position, beside_x2(1).position, atol=1e-3
    )
    assert not cell.plant.world.bullet.getContactPoints(cell.plant.robots["robot_1"].body)
