"""Vision on rendered scenes; the truth is only the score."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from panels import panel, wire
from place_wire import do

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_skills.abilities.detect_cable import detect_cable
from remodel_skills.belief_state import EndState
from remodel_skills.cell import Cell
from remodel_skills.goals import DetectGoal
from remodel_states.core.codes import Code
from remodel_states.core.wires.wire_colours import DISTINCT_COLOURS
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels
from remodel_vision.wire_ends import find_ends, line_between
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd


def test_every_label_is_found_from_above_to_half_a_millimetre(cell):
    random = np.random.default_rng(5)
    for part in cell.plant.panel.components:
        cell.plant.move_component(
            part.id, *random.uniform(-0.006, 0.006, 2), random.uniform(-0.1, 0.1)
        )
    picture = cell.plant.take_overhead_picture()
    labels = find_labels(picture, cell.plant.panel.components)
    for part in cell.plant.panel.components:
        seen = locate_component(part, [LabelView(picture, labels[part.marker_id])])
        true = cell.plant.world_from_component(part.id)
        pose = seen.world_from_component
        assert np.linalg.norm(pose.position - true.position) < 0.0005
        assert abs(pose.yaw - true.yaw) < math.radians(1.0)
        assert seen.residual < 0.0005


@pytest.mark.physics
# The darkest, the commonest and the striped one in each run of the tests.
@pytest.mark.parametrize(
    "colour",
    [
        pytest.param(name, marks=[] if name in ("BK", "BU", "GNYE") else pytest.mark.slow)
        for name in DISTINCT_COLOURS
    ],
)
def test_both_ends_of_a_wire_of_any_colour_are_found(colour):
    made = Cell(
        SimulatedPlant(
            panel(wires=(wire("W1", ("X1", "1"), ("X2", "1"), 0.48, colour=colour),)), seed=3
        )
    )
    made.feed("W1", "A")
    picture = made.plant.take_overhead_picture()
    ends, lines = find_ends(picture, made.context.wire, made.context.belief.expected)
    for end in WireEnd:
        true, out = made.plant.live.cable.tip(end)
        seen = ends[end].tip
        assert np.linalg.norm(seen.tip[:2] - true[:2]) < 0.0012
        assert abs(math.cos(seen.out_yaw) * out[0] + math.sin(seen.out_yaw) * out[1]) > 0.99
    pixels = line_between((ends[WireEnd.A], ends[WireEnd.B]), lines)
    line = picture.view.on_plane(pixels, 0.0015)[:, :2]
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    assert length == pytest.approx(0.48, rel=0.03)
    nodes = made.plant.live.cable.nodes()[:, :2]
    pieces = [np.linspace(a, b, 12) for a, b in itertools.pairwise(nodes)]
    gaps = np.linalg.norm(line[:, None] - np.concatenate(pieces)[None], axis=2)
    assert gaps.min(axis=1).max() < 0.004, "nothing but the wire, on a plate of its colour too"
    made.close()


@pytest.mark.physics
def test_a_wire_that_is_not_there_is_not_found(cell):
    cell.feed("W1", "A")
    elsewhere = {WireEnd.A: np.array([0.30, -0.30, cell.context.wire.radius])}
    ends, _ = find_ends(cell.plant.take_overhead_picture(), cell.context.wire, elsewhere)
    assert ends == {}


@pytest.mark.physics
def test_two_ends_side_by_side_are_ambiguous(cell):
    cell.feed("W1", "A")
    between = {WireEnd.A: np.mean([p for p in cell.context.belief.expected.values()], axis=0)}
    picture = cell.plant.take_overhead_picture()
    close = dataclasses.replace(cell.context.wire)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("remodel_vision.wire_ends.SEARCH_M", 0.5)
        with pytest.raises(AbilityError) as caught:
            find_ends(picture, close, between)
    assert caught.value.code is Code.CABLE_AMBIGUOUS
    assert cell.context.belief.ends[WireEnd.A] is EndState.LOOSE


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
