"""How the hand takes a wire that it lays into a clip."""

import numpy as np
import pytest
from formboards import formboard

from remodel_sim.abilities.primitives.clipping import grip_from_above
from remodel_sim.cell import Cell
from remodel_sim.core.geometry import Pose
from remodel_sim.core.workpiece.component_shape import Box
from remodel_sim.physics.static_body import add_static

# Blocks hold the wire up on both sides of the hand [m].
BESIDE_HAND_M = 0.040


def lift_onto_blocks(cell, above, y):
    """Lay a wire that was fed onto two blocks, so far above the plate [m]."""
    cable = cell.plant.live.cable
    x = float(np.interp(y, *sorted_along_y(cable.nodes())[:2]))
    blocks = [
        Box((x, y + side * BESIDE_HAND_M, above / 2), (0.030, 0.010, above), (0.8, 0.8, 0.8))
        for side in (-1, 1)
    ]
    cable.lay_along(cable.nodes() + np.array([0.0, 0.0, above]))
    add_static(cell.plant.world.bullet, blocks, Pose.level(0.0, 0.0, 0.0))


def sorted_along_y(nodes):
    order = np.argsort(nodes[:, 1])
    return nodes[order][:, [1, 0, 2]].T


@pytest.mark.parametrize("above", [0.0, 0.009, 0.016])
def test_a_wire_lies_low_between_the_pads_that_are_to_press_it_down(above):
    cell = Cell(formboard(0), seed=1)
    cell.feed("W1", "A")
    if above:
        lift_onto_blocks(cell, above, y=0.0)
    along, aside, _ = sorted_along_y(cell.plant.live.cable.nodes())
    x = float(np.interp(0.0, along, aside))
    cell.run(grip_from_above(cell.context, Pose.level(x, 0.0, 0.0015, np.pi / 2)))
    along, _, heights = sorted_along_y(cell.plant.live.cable.nodes())
    tips = cell.context.tool.z - cell.context.fingers.below
    assert 0 < float(np.interp(0.0, along, heights)) - tips < 0.005
    cell.close()
