"""Laying a held end down, wherever an interruption left it."""

import numpy as np
import pytest
from place_wire import BESIDE, ROBOT, carry, do, insert, locate
from place_wire import lay_down as lay_down_wire

from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.belief_state import EndState
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import WireEnd

pytestmark = pytest.mark.physics

# Where end a was picked, low in the channel: an end that is released high above the plate may stick
# to a finger, and one that is turned round stands up.
WHERE_FED = Pose.level(0.50, -0.13, 0.012, -1.5707963)
# So low that the fingers reach down to where the feeder's fork stands.
LOW = Pose.level(0.50, 0.11, 0.008, 1.5707963)


def lay_down(cell, target=BESIDE):
    return lay_down_wire(cell, "W1", target)


def hold_end_a_in_its_terminal(cell):
    cell.feed("W1", "A")
    insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=locate(cell, "X1", "1"))


@pytest.mark.slow
def test_an_end_that_is_pushed_in_is_drawn_out_and_can_be_picked_again(cell):
    hold_end_a_in_its_terminal(cell)
    lay_down(cell, WHERE_FED)
    assert cell.context.belief.ends[WireEnd.A] is EndState.LOOSE
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.at == ""
    do(cell, detect_cable, DetectGoal("W1"))
    do(cell, pick_cable, PickGoal(ROBOT, "W1", WireEnd.A, 0.0))
    tip, _ = cell.plant.live.cable.tip(WireEnd.A)
    held_at = cell.context.device.arm.tool.position
    assert np.linalg.norm(tip - held_at) < GRASP_DISTANCE_M + 0.010, "end a, not end b"


def test_whatever_the_hand_holds_is_laid_down_when_no_wire_is_named(cell):
    with pytest.raises(AbilityError) as caught:
        lay_down_wire(cell, "")
    assert caught.value.code is Code.NOTHING_HELD, "before the first wire was fed"
    cell.feed("W1", "A")
    do(cell, pick_cable, PickGoal(ROBOT, "W1", WireEnd.A, 0.0))
    assert lay_down_wire(cell, "").message.startswith("W1 laid down at")
    assert cell.context.belief.grip is None
    with pytest.raises(AbilityError) as caught:
        lay_down_wire(cell, "")
    assert caught.value.code is Code.NOTHING_HELD


@pytest.mark.slow
def test_an_end_that_is_fixed_is_released_in_its_terminal(cell):
    hold_end_a_in_its_terminal(cell)
    assert cell.context.device.fixture.close_clamp("X1", "1"), (
        "as FixCable does before it is stopped"
    )
    with pytest.raises(AbilityError, match="released there, the hand is empty") as caught:
        lay_down(cell)
    assert caught.value.code is Code.EXTRACTION_STUCK
    assert cell.context.belief.grip is None
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated and truth.a.fixed
    carry(cell, "W1", "A")
    lay_down(cell, LOW)
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated and truth.a.fixed, "the wire was not torn out at its other end"
