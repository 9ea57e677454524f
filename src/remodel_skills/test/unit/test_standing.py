"""A hand travels over wires that the camera has seen to stand out of the board."""

import pytest
from drawn import arch
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
