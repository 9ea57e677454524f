"""RouteWire by physics, without ROS."""

import math
from contextlib import nullcontext
from dataclasses import replace

import place_wire as do
import pytest
from formboards import along_clips, duct, formboard
from stored import put_live

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import lies_in
from remodel_skills import goals
from remodel_skills.cell import Cell
from remodel_skills.primitives.observation.route_check import check_ducts
from remodel_states.core.codes import Code
from remodel_work.component_shape import Box
from remodel_work.edge.bullet import add_static
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

pytestmark = pytest.mark.physics


def with_b_in_hand(board):
    cell = Cell(SimulatedPlant(board, seed=1))
    put_live(cell, "W1")
    do.do(cell, do.pick_cable, goals.PickGoal(do.ROBOT, "W1", WireEnd.B, 0.0))
    return cell


def route(cell, *path):
    return do.do(cell, do.route_wire, goals.RouteGoal(do.ROBOT, "W1", path))


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


@pytest.mark.parametrize(("x", "words"), [(0.0, ""), (-0.045, "2. mm beside duct 'D1'")])
def test_a_wire_beside_its_duct_is_seen_from_above(x, words):
    cell = Cell(SimulatedPlant(formboard(0, [duct(x, 0.0)]), seed=1))
    cell.feed("W1", "A")
    try:
        with pytest.raises(AbilityError, match=words) if words else nullcontext() as caught:
            cell.run(check_ducts(cell.context, (at(x, -0.1), at(x, 0.1))))
    finally:
        cell.close()
    assert not words or caught.value.code is Code.OUT_OF_DUCT


@pytest.mark.parametrize("hidden", [("D1",), ("D1", "D2")])
def test_a_wire_that_is_hidden_in_one_duct_is_judged_by_the_others(hidden):
    ducts = [duct(0.0, -0.1), replace(duct(0.0, 0.1), id="D2")]
    cell = Cell(SimulatedPlant(formboard(0, ducts), seed=1))
    cell.feed("W1", "A")
    for one in ducts:
        if one.id in hidden:
            cover = Box((0.0, 0.0, 0.03), (0.2, 0.2, 0.002), (0.5, 0.5, 0.5), solid=False)
            add_static(cell.plant.world.bullet, [cover], BOARD @ one.panel_from_duct)
    try:
        with pytest.raises(AbilityError) if len(hidden) > 1 else nullcontext() as caught:
            cell.run(check_ducts(cell.context, (at(0.0, -0.2), at(0.0, 0.2))))
    finally:
        cell.close()
    assert caught is None or caught.value.code is Code.CABLE_OCCLUDED
