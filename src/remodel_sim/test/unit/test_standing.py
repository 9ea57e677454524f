"""Wires that stand out of the board, as the camera sees them, and the motions that go over them."""

import math

import numpy as np
import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.belief_state import NO_CHANNEL, Feed
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives.motions import move_to, swing_to
from remodel_vision.standing import CELL_M, standing_wires
from remodel_work.edge.cell_file import read_cell
from remodel_work.obstacles import WIRES, panel_obstacles
from remodel_work.panel import BOARD, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import ParkedWire

MOTION = read_parameters().parameters.motion
PANEL = panel(channels=())
# A finished wire that arches across the plate, higher than a hand travels [m].
ARCH_TOP = 0.115
ARCH_Y = -0.05
SPAN = 0.30
NODES = 61


@pytest.fixture(scope="module", params=["cabinet", "two_arms_cabinet"])
def cell(request):
    made = Cell(SimulatedPlant(PANEL, design=read_cell(request.param)))
    yield made
    made.close()


def seen(cell):
    picture = cell.plant.take_overhead_picture()
    return standing_wires([picture], PANEL, panel_obstacles(PANEL, {}))


def lay_arch(cell):
    middle = BOARD.position[0]
    x = np.linspace(-SPAN / 2, SPAN / 2, NODES)
    z = 0.003 + (ARCH_TOP - 0.003) * np.cos(math.pi * x / SPAN)
    nodes = np.column_stack([middle + x, np.full(NODES, ARCH_Y), z])
    cell.plant.load(cell.plant.loaded, {"W2": ParkedWire(nodes, frozenset(WireEnd))})
    return nodes


@pytest.mark.slow
@pytest.mark.physics
def test_a_hand_travels_over_a_wire_that_stands_out(cell):
    nodes = lay_arch(cell)
    columns = seen(cell).solids
    assert {column.name for column in columns} == {WIRES}
    for column in columns:
        (x, y, middle), height = column.box.centre, column.box.size[2]
        assert abs(y - ARCH_Y) < 2 * CELL_M
        beneath = nodes[np.abs(nodes[:, 0] - x) <= CELL_M, 2]
        assert beneath.min() - 0.004 < middle + height / 2 < beneath.max() + 0.006
    context = cell.context
    context.belief.feed = Feed("W1", NO_CHANNEL, 1)
    context.cameras.take_overhead_pictures()
    x = float(BOARD.position[0])
    heights = []

    def steps():
        yield from move_to(
            context,
            ToolPose(x, -0.20, MOTION.lifts_z_m[-1], 0.0),
            MOTION.free_speed_m_s,
        )
        yield from move_to(
            context,
            ToolPose(x, -0.20, MOTION.travel_z_m, 0.0),
            MOTION.free_speed_m_s,
        )
        for _ in swing_to(context, ToolPose(x, 0.10, MOTION.travel_z_m, 0.0)):
            heights.append(context.commanded.z)
            robot = cell.plant.robots["robot_1"].body
            assert not cell.plant.world.bullet.getContactPoints(robot)
            yield

    cell.run(steps())
    assert max(heights) == pytest.approx(MOTION.lifts_z_m[1])
    assert heights[-1] == pytest.approx(MOTION.travel_z_m)
