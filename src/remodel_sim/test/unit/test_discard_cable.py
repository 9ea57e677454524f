"""Wires leave the cell by the scrap bin, whatever holds them, and only there."""

import numpy as np
import place_wire as do
import pytest
from panels import panel
from stored import put, put_live, shape_of, stored

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.abilities.picking import DetectGoal
from remodel_skills.belief_state import EndState
from remodel_skills.cell import Cell
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives import carrying
from remodel_skills.primitives.picking_up import take_up
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd

PARAMETERS = read_parameters().parameters
# A hand that has carried a wire so far loses it [m].
CARRIED_M = 0.10


def discard(cell, wire):
    return do.do(cell, discard_cable, DiscardGoal(do.ROBOT, wire))


def assert_gone(cell, wire):
    belief = cell.context.belief
    assert cell.plant.live is None and wire not in cell.plant.parked
    assert wire not in belief.fed and not belief.hands
    assert wire not in [held[0] for held in belief.occupied.values()]
    assert ground_truth(cell.plant, [wire]) == []
    half = cell.context.panel.size[1] / 2
    assert abs(cell.context.device.arm.tool.y) > half + 0.05, "it was dropped beyond the plate"


@pytest.mark.physics
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_piece_that_lies_in_its_channel_is_dropped_into_the_bin(seed):
    cell = Cell(SimulatedPlant(panel(), seed=seed))
    cell.feed("W1", "A")
    goal = DiscardGoal(do.ROBOT, "W1")
    steps = discard_cable(cell.context, goal)
    while cell.context.progress.message != "dropping the wire":
        next(steps)
        for _ in range(cell.plant.steps_per_tick):
            cell.plant.step()
        assert cell.plant.live is not None, "it leaves the world over the bin only"
    for _ in steps:
        is_known = "W1" in cell.context.belief.fed
        assert (cell.plant.live is not None) == is_known, "a cancel may come now"
        for _ in range(cell.plant.steps_per_tick):
            cell.plant.step()
    assert_gone(cell, "W1")
    assert discard(cell, "W1").message == "no piece of W1 is in the cell"
    cell.feed("W1", "A")
    assert not cell.context.belief.is_touched
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_the_wire_in_the_hand_is_discarded_with_its_other_end_connected(cell):
    with pytest.raises(AbilityError) as caught:
        discard(cell, "")
    assert caught.value.code is Code.NOTHING_HELD
    put_live(cell, "W1")
    do.carry(cell, "W1", "A")
    with pytest.raises(AbilityError) as caught:
        discard(cell, "W2x")
    assert caught.value.code is Code.UNKNOWN_NAME
    assert discard(cell, "W2").message == "no piece of W2 is in the cell"
    assert discard(cell, "").message == "W1 dropped into the scrap bin"
    assert_gone(cell, "W1")


@pytest.mark.slow
@pytest.mark.physics
def test_a_placed_wire_is_released_and_discarded_by_a_cell_that_was_restarted(tmp_path):
    memory = CellMemory(tmp_path)
    first = Cell(SimulatedPlant(panel(), seed=3))
    memory.keep(panel(), stored(panel(), "W1", shape_of(first, "W1", *WireEnd)))
    first.close()
    cell = Cell(SimulatedPlant(panel(), seed=3), memory=memory)
    cell.feed("W2", "A")
    discard(cell, "W1")
    assert_gone(cell, "W1")
    assert list(cell.plant.parked) == ["W2"], "another wire stays"
    cell.keep()
    assert list(memory.placed(panel()).parked) == ["W2"]
    cell.close()
    memory.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_placed_wire_is_extracted_and_discarded(cell):
    put(cell, "W1", *WireEnd)
    take_up(cell.context, "W1")
    do.extract(cell, "W1", "X2", "1", socket=do.locate(cell, "X2", "1"))
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated and truth.a.fixed and truth.b.at == ""
    discard(cell, "W1")
    assert_gone(cell, "W1")


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.parametrize("placed", [False, True], ids=["fed", "placed"])
def test_a_wire_that_falls_before_the_bin_is_seen_to_lie_there(cell, monkeypatch, placed):
    if placed:
        put(cell, "W1", *WireEnd)
    else:
        cell.feed("W1", "A")
        do.do(cell, do.detect_cable, DetectGoal("W1"))
    context = cell.context
    with monkeypatch.context() as patch:
        patch.setattr(carrying, "check_grip", lambda context: None)  # as if it felt the wire
        steps = discard_cable(context, DiscardGoal(do.ROBOT, "W1"))
        with pytest.raises(AbilityError, match="still seen on the board") as caught:
            while True:
                next(steps)
                if not context.progress.message.startswith("carrying"):
                    begun = context.device.arm.tool
                elif (
                    np.linalg.norm((context.device.arm.tool.position - begun.position)[:2])
                    > CARRIED_M
                ):
                    context.drive_fingers(PARAMETERS.tool.open_m)
                for _ in range(cell.plant.steps_per_tick):
                    cell.plant.step()
    assert caught.value.code is Code.GRASP_SLIPPED
    assert cell.plant.live is not None and "W1" in context.belief.fed
    assert not context.belief.hands


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_whose_end_is_stuck_stays(cell, monkeypatch):
    put_live(cell, "W1")
    with monkeypatch.context() as patch:
        patch.setattr(cell.plant, "open_clamp", lambda *terminal: None)  # its screw is jammed
        with pytest.raises(AbilityError, match="it was released there") as caught:
            discard(cell, "W1")
    assert caught.value.code is Code.EXTRACTION_STUCK
    assert not cell.context.belief.hands
    assert cell.context.belief.ends[WireEnd.A] is EndState.SEATED
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated
    with pytest.raises(AbilityError) as caught:
        cell.feed("W1", "A")
    assert caught.value.code is Code.WIRE_LEFT_BEHIND
    discard(cell, "W1")
    assert_gone(cell, "W1")
