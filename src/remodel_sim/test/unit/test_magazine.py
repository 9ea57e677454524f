"""The magazine: where it presents a wire, how the wire rests there, and how it is taken out."""

import math

import numpy as np
import pytest
from dense_board import board_wire, dense_panel
from place_wire import ROBOT, do, fix, insert, lay_down, locate

from remodel_sim.physics.live_wire import present
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.world import World
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.cell import Cell
from remodel_work.cell.presenting import Magazine
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd

MAGAZINE = Magazine(x=0.20, height=0.050, span=0.46, y_min=-0.30, y_max=0.40)
TO_THE_LEFT = board_wire("W1", ("N1", "b1"), ("N2", "b10"), 0.53)
# How far from its place a tip may come to rest: the clips' tolerance, and a pitch of 6 degrees.
RESTS_WITHIN_M = 0.005


@pytest.mark.physics
@pytest.mark.parametrize(
    "length, changes",
    [
        (0.42, {}),
        (0.53, {}),
        (1.35, {}),
        (0.95, {"diameter": 0.0061, "linear_density": 0.115, "bending_stiffness": 6e-3}),
    ],
)
def test_the_ends_rest_at_their_places_and_one_comes_out_at_a_light_force(length, changes):
    world = World(240.0)
    wire = board_wire("W1", ("N1", "b1"), ("N2", "b10"), length, **changes)
    noise = np.random.default_rng(1)
    cable, presentation, clips = present(world, MAGAZINE, dense_panel([wire]), wire, noise)
    assert len({*clips[WireEnd.A], *clips[WireEnd.B]}) == 4, "two clips hold each end"
    for end in WireEnd:
        away = cable.tip(end)[0] - presentation.tips[end].position
        assert np.abs(away).max() < RESTS_WITHIN_M, f"end {end.value} rests {away} m away"
    rested = cable.tip(WireEnd.B)[0]
    limit = 2.5 * max(1.0, wire.bending_stiffness / 1.6e-3)
    # A hand lifts an end by 20 mm; a long wire follows it farther.
    assert _lift(world, cable, 0.04 if length < 0.48 else 0.15) < limit
    assert np.linalg.norm(cable.tip(WireEnd.B)[0] - rested) < RESTS_WITHIN_M
    world.close()


def _lift(world, cable, height):
    """Lift end a where a hand holds it; return the largest force [N], as a wrist measures it."""
    bullet, (body, _) = world.bullet, cable.ferrule(WireEnd.A)
    start, turn = cable.link_pose((body, 0))
    hand = bullet.createConstraint(
        body, 0, -1, -1, bullet.JOINT_FIXED, [0, 0, 0],
        [0, 0, 0], start.tolist(), [0, 0, 0, 1], turn.tolist(),
    )  # fmt: skip
    largest, felt = 0.0, np.zeros(3)
    steps = round(height / 0.05 / world.time_step)
    for step in range(1, steps + 1):
        at = start + np.array([0.0, 0.0, height * step / steps])
        bullet.changeConstraint(hand, at.tolist(), turn.tolist(), maxForce=500)
        world.step()
        felt += 0.1 * (np.array(bullet.getConstraintState(hand)[:3]) - felt)
        largest = max(largest, float(np.linalg.norm(felt)))
    return largest


@pytest.fixture(scope="module")
def cabinet():
    """A cell with a magazine, a wire presented there."""
    cell = Cell(SimulatedPlant(dense_panel([TO_THE_LEFT]), design=read_cell("cabinet"), seed=1))
    cell.feed("W1", "")
    yield cell
    cell.close()


@pytest.mark.physics
def test_cameras_find_both_ends_where_they_are_and_how_high(cabinet):
    found = do(cabinet, detect_cable, DetectGoal("W1"))
    for end, seen in zip(WireEnd, found.tips, strict=True):
        tip, out = cabinet.plant.live.cable.tip(end)
        assert np.abs(seen.tip - tip).max() < 0.0015
        assert seen.pitch == pytest.approx(math.asin(out[2]), abs=math.radians(2.0))


@pytest.mark.slow
@pytest.mark.physics
def test_an_end_goes_from_its_clips_into_its_terminal_and_the_wire_can_be_discarded(cabinet):
    socket = locate(cabinet, "N1", "b1")
    insert(cabinet, "W1", WireEnd.A, "N1", terminal="b1", socket=socket)
    fix(cabinet, "W1", "N1", "b1")
    do(cabinet, discard_cable, DiscardGoal(ROBOT, "W1"))
    assert cabinet.plant.live is None
    assert cabinet.context.belief.fed == []


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_nothing_else_holds_is_dropped_wherever_it_is_to_be_laid_down(cabinet):
    cabinet.feed("W1", "")
    do(cabinet, pick_cable, PickGoal(ROBOT, "W1", WireEnd.A, 0.0))
    lay_down(cabinet, "W1", Pose.level(5.0, 5.0, 0.06, 0.0))
    assert cabinet.context.belief.grip is None
    assert cabinet.context.belief.fed == []
    assert cabinet.plant.live is None
