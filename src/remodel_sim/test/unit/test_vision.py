"""Vision on rendered scenes; the truth is only the score."""

import dataclasses

import numpy as np
import pytest
from place_wire import do

from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_skills.abilities.picking import DetectGoal, detect_cable
from remodel_states.core.codes import Code
from remodel_vision.wire_ends import find_ends
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd


@pytest.mark.slow
@pytest.mark.physics
def test_an_end_that_a_wire_in_the_air_hides_from_above_is_found_from_aside(cell):
    cell.feed("W1", "A")
    live = cell.context.wire
    tip, _ = cell.plant.live.cable.tip(WireEnd.A)
    ferrule = np.array([tip[0], tip[1] + live.ferrule_length / 2, live.radius])
    lens = cell.plant.take_overhead_picture().view.world_from_camera.position
    on_the_ray = ferrule + (lens - ferrule) * 0.05 / lens[2]  # some 50 mm above the plate
    across = np.linspace(-0.25, 0.25, 13)[:, None] * np.array([1.0, 0.0, 0.0])
    draw_parked(
        cell.plant.world,
        on_the_ray + across,
        dataclasses.replace(live, diameter=0.012, colour="RD"),
    )
    seen, _ = find_ends(cell.plant.take_overhead_picture(), live, cell.context.belief.expected)
    assert WireEnd.A not in seen, "the wire above hides it"
    do(cell, detect_cable, DetectGoal("W1"))
    assert np.linalg.norm(cell.context.belief.tips[WireEnd.A].tip[:2] - tip[:2]) < 0.003


@pytest.mark.physics
def test_an_end_that_lies_elsewhere_is_not_mistaken_for_the_other_one(cell):
    cell.feed("W1", "A")
    expected = cell.context.belief.expected
    expected[WireEnd.A] = expected[WireEnd.B] + np.array([0.030, 0.0, 0.0])
    with pytest.raises(AbilityError, match=r"end a of 'W1' .* is hidden") as caught:
        do(cell, detect_cable, DetectGoal("W1"))
    assert caught.value.code is Code.TIP_NOT_FOUND
    assert WireEnd.A not in cell.context.belief.tips
