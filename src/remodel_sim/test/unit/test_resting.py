"""Parts of a wire that rest are static until a force that changes comes, and change nothing."""

import math

import numpy as np
import pytest
import rods
from elastica import cantilever_drop
from holds import pull_out, wire_in_hand
from panels import panel, wire

from remodel_sim.core.wire_mechanics import GRAVITY, discretise
from remodel_sim.physics.fixtures.panel_scene import PLATE_FRICTION, add_plate_surface
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.robot import HAND_30_N
from remodel_sim.physics.wires.cable import CLEAR_M, NEAR_M, STILL_M, STILL_S, SimulatedWire
from remodel_sim.physics.world import World
from remodel_work.panel import WireEnd

pytestmark = pytest.mark.physics

RATE_HZ = 240
NOTHING = (np.zeros((0, 3)), np.zeros((0, 3)))
# What moves, in these tests: a cube of this size [m].
SIZE_M = 0.01
# A wire is drawn by its end so fast, by a spring [m/s, N/m, N s/m].
DRAWN_M_S, SPRING_N_M, DAMPING_N_S_M = 0.002, 200.0, 1.0


class Hand:
    """A cube that moves; `at` is its middle (3,) [m], None: there is none."""

    def __init__(self, at=None):
        self.at = at

    def boxes(self):
        if self.at is None:
            return NOTHING
        middle = np.asarray(self.at)[None]
        return middle - SIZE_M / 2, middle + SIZE_M / 2


def on_plate(length=1.0, *, curvature=0.4, hand=None, rests=True, **changes):
    """Return a world with a wire on the plate, from (0, 0) along x, and what moves in it."""
    world = World(RATE_HZ)
    add_plate_surface(world)
    specimen = wire("W", ("X", "1"), ("Y", "1"), length, **changes)
    cable = SimulatedWire(world, discretise(specimen, world.time_step), "BU")
    bends = np.where(cable.model.spans > 0, curvature, 0.0)
    cable.lay(np.array([0.0, 0.0, specimen.radius]), 0.0, bends)
    hand = hand or Hand()
    if rests:
        cable.let_rest(hand.boxes)
    return world, cable, hand


def run(world, seconds):
    for _ in range(round(seconds * RATE_HZ)):
        world.step()


def test_a_wire_at_rest_is_static_and_keeps_its_place():
    world, cable, _ = on_plate()
    run(world, STILL_S / 2)
    assert not any(cable.resting), "it has to be still for a while"
    run(world, 2 * STILL_S)
    assert len(cable.resting) > 1
    assert all(cable.resting)
    assert not world.bullet.getContactPoints(), "nothing is solved"
    before = cable.nodes()
    run(world, 1.0)
    assert np.array_equal(cable.nodes(), before)
    cable.wake()
    assert np.array_equal(cable.nodes(), before), "it wakes as it lay"
    run(world, STILL_S)
    assert np.abs(cable.nodes() - before).max() < STILL_M, "and lies there by itself"
    world.close()


def test_a_part_wakes_before_what_moves_touches_it_and_rests_again():
    world, cable, hand = on_plate()
    run(world, 2 * STILL_S)
    middle = cable.nodes()[len(cable.nodes()) // 2]
    hand.at = middle + np.array([0.0, 0.0, NEAR_M + SIZE_M])
    run(world, 0.05)
    assert all(cable.resting), "it is not near"
    hand.at = middle + np.array([0.0, 0.0, NEAR_M])
    run(world, 0.05)
    assert not all(cable.resting)
    assert cable.resting[0], "the ends are far away"
    assert cable.resting[-1]
    run(world, 2 * STILL_S)
    assert not all(cable.resting), "while it is near"
    hand.at = middle + np.array([0.0, 0.0, CLEAR_M + SIZE_M])
    run(world, 2 * STILL_S)
    assert all(cable.resting)
    world.close()


def test_a_part_wakes_when_its_neighbour_is_loaded_otherwise_and_not_when_it_is_not():
    world, cable, _ = on_plate(hand=Hand([0.0, 0.0, 0.0]))
    run(world, 2 * STILL_S)
    assert not cable.resting[0], "the hand is there"
    assert all(cable.resting[1:])
    link = cable.ferrule(WireEnd.A)

    def lift(force, seconds):
        for _ in range(round(seconds * RATE_HZ)):
            place = cable.link_pose(link)[0].tolist()
            world.bullet.applyExternalForce(*link, [0, 0, force], place, world.bullet.WORLD_FRAME)
            world.step()

    weight = cable.model.masses[:4].sum() * GRAVITY
    lift(0.2 * weight, 0.5)
    assert all(cable.resting[1:]), "nothing reaches the second body"
    lift(20 * weight, 0.3)
    assert not cable.resting[1]
    world.close()


def test_a_part_of_the_same_wire_wakes_one_that_it_comes_to():
    """The wire lies in a circle, and one end is pushed towards the other one."""
    world, cable, hand = on_plate(curvature=6.0)
    tips = np.array([cable.tip(end)[0] for end in (WireEnd.A, WireEnd.B)])
    hand.at = tips[1] - 0.5 * (tips[0] - tips[1])
    run(world, 2 * STILL_S)
    assert cable.resting == [True] * (len(cable.resting) - 1) + [False]
    link, towards = cable.ferrule(WireEnd.B), tips[0] - tips[1]
    for _ in range(RATE_HZ):
        place = cable.link_pose(link)[0].tolist()
        force = (0.03 * towards / np.linalg.norm(towards)).tolist()
        world.bullet.applyExternalForce(*link, force, place, world.bullet.WORLD_FRAME)
        world.step()
        if not cable.resting[0]:
            break
    assert not cable.resting[0]
    assert all(cable.resting[1:3]), "it did not come along the wire"
    assert np.linalg.norm(cable.tip(WireEnd.A)[0] - tips[0]) < STILL_M, "nothing touched it yet"
    world.close()


@pytest.mark.parametrize("length", [0.5, 1.0])
def test_a_clamped_wire_whose_parts_may_rest_hangs_like_the_heavy_elastica(length):
    rod = rods.CellRod(length, load=5.0)
    rod.cable.let_rest(lambda: NOTHING)
    expected = cantilever_drop(length, 1.0, 5.0 / length**3)
    assert rods.drop_at_rest(rod) == pytest.approx(expected, rel=0.003)


def drag(rests):
    """Draw a straight wire along the plate by its end; return the force over mu m g."""
    hand = Hand([0.0, 0.0, 0.0])
    world, cable, hand = on_plate(curvature=0.0, hand=hand, rests=rests)
    run(world, 2 * STILL_S)
    assert any(cable.resting) == rests
    link = cable.ferrule(WireEnd.A)
    coulomb = PLATE_FRICTION * cable.model.friction * cable.model.masses.sum() * GRAVITY
    start = before = float(cable.link_pose(link)[0][0])
    forces = []
    slides_s = coulomb / SPRING_N_M / DRAWN_M_S + 0.5
    for step in range(round(2 * slides_s * RATE_HZ)):
        place = cable.link_pose(link)[0]
        hand.at = place
        stretch = place[0] - start + DRAWN_M_S * step / RATE_HZ
        speed = (place[0] - before) * RATE_HZ
        before = float(place[0])
        forces.append(SPRING_N_M * stretch + DAMPING_N_S_M * (speed + DRAWN_M_S))
        pull = [-forces[-1], 0, 0]
        world.bullet.applyExternalForce(*link, pull, place.tolist(), world.bullet.WORLD_FRAME)
        world.step()
    assert not any(cable.resting), "it slides"
    world.close()
    return float(np.mean(forces[round(slides_s * RATE_HZ) :])) / coulomb


def test_a_wire_whose_parts_may_rest_is_dragged_with_the_same_force():
    assert drag(rests=True) == pytest.approx(drag(rests=False), rel=0.02)


def test_a_wire_whose_parts_may_rest_is_drawn_out_of_the_grip_with_the_same_force():
    def held(rests):
        world = World(RATE_HZ)
        world.bullet.setGravity(0, 0, 0)
        robot, cable = wire_in_hand(world, length=0.8)
        if rests:
            cable.let_rest(robot.boxes)
        robot.grip_force = 10.0
        robot.drive_fingers(0.0)
        run(world, 3.0)
        assert any(cable.resting) == rests
        expected = 2 * HAND_30_N.pad_friction * 0.5 * robot.grip_force
        force = pull_out(world, cable, WireEnd.B, np.array([0.0, 1.0, 0.0]), expected=expected)
        world.close()
        return force

    assert held(rests=True) == pytest.approx(held(rests=False), rel=0.05)


@pytest.mark.repeats
def test_a_wire_whose_parts_may_rest_moves_the_same_to_the_bit_again():
    def moved():
        hand = Hand([0.0, 0.0, 0.0])
        world, cable, hand = on_plate(hand=hand)
        run(world, 2 * STILL_S)
        assert any(cable.resting)
        link = cable.ferrule(WireEnd.A)
        for step in range(RATE_HZ):
            hand.at = cable.link_pose(link)[0]
            force = [0.0, 0.5 * math.sin(0.02 * step), 0.3]
            world.bullet.applyExternalForce(
                *link, force, hand.at.tolist(), world.bullet.WORLD_FRAME
            )
            world.step()
        run(world, 2 * STILL_S)
        state = cable.nodes().tobytes()
        world.close()
        return state

    assert moved() == moved()


def test_the_cell_wakes_a_wire_before_it_changes_what_that_lies_in():
    plant = SimulatedPlant(panel(), seed=1)
    tools = {name: robot.tool for name, robot in plant.robots.items()}
    plant.feed("W1", "A", tools)
    changes = (
        plant.lower_fork,
        lambda: plant.close_clamp("X1", "1"),
        lambda: plant.open_clamp("X1", "1"),
        lambda: plant.block_socket("X1", "1"),
        lambda: plant.clear_socket("X1", "1"),
        lambda: plant.move_component("X1", 0.001, 0.0, 0.0),
        lambda: plant.disturb("tip_bent", "a", [0.1]),
    )
    for change in changes:
        plant.rest(4 * STILL_S)
        assert all(plant.live.cable.resting)
        change()
        assert not any(plant.live.cable.resting)
    plant.close()
