"""A hand travels over wires that the camera has seen to stand out of the board."""

import math

import numpy as np
import pytest
from panels import panel
from scripted_device import PARAMETERS, ScriptedPlant

from remodel_skills.belief_state import NO_CHANNEL, Feed
from remodel_skills.cell import Cell
from remodel_skills.primitives.motions import move_to, swing_to
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import BOARD
from remodel_work.robot.arm import ToolPose

MOTION = PARAMETERS.motion
PANEL = panel(channels=())
X = float(BOARD.position[0])
# A wire that arches across the plate, higher than a hand travels [m].
ARCH_TOP_M, ARCH_Y, SPAN_M = 0.115, -0.05, 0.30


def arch():
    """Return the nodes of a wire that stands out of the plate across it, (n, 3) [m]."""
    x = np.linspace(-SPAN_M / 2, SPAN_M / 2, 61)
    z = 0.003 + (ARCH_TOP_M - 0.003) * np.cos(math.pi * x / SPAN_M)
    return np.column_stack([X + x, np.full(61, ARCH_Y), z])


@pytest.mark.parametrize(
    ("design", "stands"), [("cabinet", False), ("cabinet", True), ("two_arms_cabinet", True)]
)
def test_a_hand_travels_over_a_wire_that_stands_out(design, stands):
    cell = Cell(ScriptedPlant(PANEL, read_cell(design)))
    context, plant = cell.context, cell.plant
    plant.wires = [(PANEL.wire("W2"), arch())] if stands else []
    context.belief.feed = Feed("W1", NO_CHANNEL, 1)
    context.cameras.take_overhead_pictures()
    before = ToolPose(X, -0.20, MOTION.travel_z_m, 0.0)
    cell.run(move_to(context, before.at(z=MOTION.lifts_z_m[-1]), MOTION.free_speed_m_s))
    cell.run(move_to(context, before, MOTION.free_speed_m_s))
    plant.trace[context.name].clear()
    cell.run(swing_to(context, ToolPose(X, 0.10, MOTION.travel_z_m, 0.0)))
    heights = [tool.z for tool, _ in plant.trace[context.name]]
    assert max(heights) == pytest.approx(MOTION.lifts_z_m[1] if stands else MOTION.travel_z_m)
    assert heights[-1] == pytest.approx(MOTION.travel_z_m)
    cell.close()
