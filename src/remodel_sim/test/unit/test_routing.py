"""RouteWire by physics, without ROS."""

import math

import place_wire as do
import pytest
from formboards import along_clips, formboard
from stored import put_live

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import lies_in
from remodel_skills.abilities.picking import PickGoal
from remodel_skills.abilities.route_wire import RouteGoal
from remodel_skills.cell import Cell
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

pytestmark = pytest.mark.physics


def with_b_in_hand(board):
    cell = Cell(SimulatedPlant(board, seed=1))
    put_live(cell, "W1")
    do.do(cell, do.pick_cable, PickGoal(do.ROBOT, "W1", WireEnd.B, 0.0))
    return cell


def route(cell, *path):
    return do.do(cell, do.route_wire, RouteGoal(do.ROBOT, "W1", path))


def at(x, y, z=0.05):
    return BOARD @ Pose.level(x, y, z, math.pi / 2)


def test_a_wire_is_laid_into_its_clips_and_stays_there():
    board = formboard(2)
    cell = with_b_in_hand(board)
    done = route(cell, *along_clips(board))
    assert done.message == "W1 laid into C1, C2"
    assert cell.context.belief.grip is None
    assert all(lies_in(cell.plant, "W1", clip) for clip in board.clips)
    cell.close()


@pytest.mark.slow
def test_a_wire_too_short_for_its_path_pulls_back():
    cell = with_b_in_hand(formboard(0))
    with pytest.raises(AbilityError) as caught:
        route(cell, at(0.0, 0.30), at(0.0, 0.45))
    assert caught.value.code is Code.SNAGGED
    assert caught.value.found["reached"] == 1
    cell.close()
