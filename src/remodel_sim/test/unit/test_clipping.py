"""How the hand takes a wire that it lays into a clip, and presses it in."""

import numpy as np
import pytest
from formboards import formboard

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.cell import Cell
from remodel_skills.primitives.clips_and_forks import grip_from_above, press_around
from remodel_work.component_shape import Box
from remodel_work.edge.bullet import add_static
from remodel_work.geometry import Pose
from remodel_work.routes import world_from_clip

pytestmark = pytest.mark.physics

BLOCK_RGB = (0.8, 0.8, 0.8)
# A block that holds the wire up is so long along it [m].
BLOCK_M = 0.003


def with_wire(board, x, y, line):
    """Return a cell with the wire along y past (x, y), held up by blocks.

    `line`: the heights of its axis [m] by the distance from y [m]; blocks are at the ends of it.
    """
    cell = Cell(SimulatedPlant(board, seed=1))
    cell.feed("W1", "A")
    cable = cell.plant.live.cable
    nodes = cable.nodes()
    aside, _ = beside(cell, y)
    along, heights = np.array(sorted(line.items())).T
    nodes[:, 0] += x - aside
    nodes[:, 2] = np.interp(nodes[:, 1] - y, along, heights)
    cable.lay_along(nodes)
    blocks = [
        Box((x, y + out, (height - 0.0015) / 2), (0.030, BLOCK_M, height - 0.0015), BLOCK_RGB)
        for out, height in (min(line.items()), max(line.items()))
    ]
    add_static(cell.plant.world.bullet, blocks, Pose.level(0.0, 0.0, 0.0))
    return cell


def beside(cell, y):
    """Return where the wire passes y: its x and its height [m]."""
    nodes = cell.plant.live.cable.nodes()
    x, along, heights = nodes[np.argsort(nodes[:, 1])].T
    return float(np.interp(y, along, x)), float(np.interp(y, along, heights))


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.004, 0.0105, 0.0175])
def test_a_wire_lies_low_between_the_pads_that_are_to_press_it_down(height):
    cell = with_wire(formboard(0), 0.50, 0.0, {-0.040: height, 0.040: height})
    cell.run(grip_from_above(cell.context, Pose.level(0.50, 0.0, 0.0015, np.pi / 2)))
    tips = cell.context.device.arm.tool.z - cell.context.fingers.below
    assert 0 < beside(cell, 0.0)[1] - tips < 0.005
    cell.close()


def test_a_wire_that_stands_on_its_lips_at_one_end_is_pressed_in_at_both():
    board = formboard(1)
    (clip,) = board.clips
    x, y, _ = world_from_clip(clip, board).position
    cell = with_wire(board, x, y, {-0.036: 0.0197, 0.0: 0.0115, 0.036: 0.0092})
    cell.run(press_around(cell.context, clip))
    for end in (-clip.length / 2, clip.length / 2):
        assert beside(cell, y + end)[1] == pytest.approx(clip.height, abs=0.0007)
    cell.close()
