import dataclasses
import math

import numpy as np
import pytest
import rods
from elastica import buckled_tip_angle, cantilever_drop
from panels import wire

from remodel_sim.core.wire_mechanics import MAX_LINKS, discretise
from remodel_sim.physics.fixtures.panel_scene import add_plate_surface
from remodel_sim.physics.wires.cable import SimulatedWire, link_colours
from remodel_sim.physics.wires.parked_wire import add_solid, draw_parked
from remodel_sim.physics.world import World
from remodel_states.core.wires import rgbs_of
from remodel_vision.colour import wire_likelihood
from remodel_work.component_shape import FERRULE_RGB
from remodel_work.panel import WireEnd


def ordered(length, **changes):
    return wire("W", ("X", "1"), ("Y", "1"), length, **changes)


@pytest.mark.parametrize("length", [0.34, 0.5, 0.75, 1.2, 3.0])
def test_the_links_add_up_to_the_wire(length):
    whole = ordered(length)
    model = discretise(whole, 1 / 240)
    assert math.isclose(model.lengths.sum() + 2 * model.radius, length)
    assert math.isclose(model.masses.sum(), length * whole.linear_density)
    assert math.isclose(model.spans.sum(), length - 2 * whole.ferrule_length)
    assert all(last - first <= MAX_LINKS for first, last in model.bodies)
    # One body fewer would have one half of a cell fewer.
    assert (len(model.bodies) - 1) * MAX_LINKS < len(model.lengths) - 1, "no more than it needs"


def test_torques_pull_back_to_the_rest_shape():
    model = discretise(ordered(0.4), 1 / 240)
    bend = np.zeros_like(model.stiffness)
    bend[5, 0] = 0.1
    torque = model.torques(bend, np.zeros_like(bend))[5, 0]
    assert torque == pytest.approx(-0.1 * model.stiffness[5, 0])


def test_a_joint_yields_beyond_its_limit_and_hardens():
    model = discretise(ordered(0.4, yield_curvature=5.0, hardening=0.25), 1 / 240)
    limit = model.yield_angles[5]
    bend, none = np.zeros((len(model.spans), 2)), np.zeros((len(model.spans), 2))
    bend[5] = [0.6 * limit, 0.8 * limit]
    assert model.yielded(bend, none) is none, "at the limit nothing yields"
    plastic = model.yielded(3.0 * bend, none)
    elastic = np.linalg.norm(3.0 * bend[5] - plastic[5])
    assert elastic == pytest.approx((1.0 + 0.25 * 2.0) * limit), "a quarter of EI beyond it"
    assert np.all(plastic[:5] == 0.0)
    again = model.yielded(3.0 * bend, plastic)
    assert again == pytest.approx(plastic), "the set is a set"


@pytest.mark.physics
@pytest.mark.parametrize("load", [1.0, 5.0, 21.0])
def test_a_clamped_wire_hangs_like_the_heavy_elastica(load):
    expected = cantilever_drop(rods.LENGTH, 1.0, load / rods.LENGTH**3)
    assert rods.sag(load) == pytest.approx(expected, rel=0.003)


@pytest.mark.physics
def test_a_wire_of_two_bodies_hangs_like_one():
    assert rods.sag(5.0, cut=12) == pytest.approx(rods.sag(5.0), rel=1e-3)


@pytest.mark.physics
def test_a_wire_of_a_metre_as_the_cell_makes_it_hangs_like_the_heavy_elastica():
    expected = cantilever_drop(1.0, 1.0, 5.0)
    assert rods.drop_at_rest(rods.CellRod(1.0, load=5.0)) == pytest.approx(expected, rel=0.003)


@pytest.mark.physics
def test_a_pushed_wire_buckles_at_eulers_load_and_not_before():
    assert rods.buckle(0.97) < math.radians(0.5)
    assert rods.buckle(1.2) == pytest.approx(buckled_tip_angle(1.2), abs=math.radians(0.5))


@pytest.mark.physics
def test_an_overbent_wire_keeps_a_set():
    def left_after_bending(**properties):
        rod = rods.Rod(**properties)
        moment_free_angle = rod.tip_angle
        rod.come_to_rest((0.0, 0.0, 0.03))
        rod.come_to_rest()
        angle = rod.tip_angle
        rod.close()
        return angle - moment_free_angle

    assert left_after_bending(yield_curvature=4.0) > math.radians(5)
    assert left_after_bending(yield_curvature=100.0) < math.radians(0.1)


@pytest.mark.physics
def test_a_twisted_wire_turns_by_torsion_alone():
    rod = rods.Rod(torsional_stiffness=0.8e-3)
    torque, link = 2e-4, rod.cable.ferrule(WireEnd.B)
    bullet = rod.world.bullet
    for _ in range(240 * 4):
        bullet.applyExternalTorque(*link, [torque, 0, 0], bullet.WORLD_FRAME)
        rod.world.step()
    turned = bullet.getDifferenceQuaternion(
        rod.cable.link_pose(rod.cable.ferrule(WireEnd.A))[1].tolist(),
        rod.cable.link_pose(link)[1].tolist(),
    )
    rod.close()
    # The last half cell carries no torque on from its middle.
    flexible = rods.LENGTH * (1 - 0.5 / 24)
    assert 2 * math.atan2(turned[0], turned[3]) == pytest.approx(
        torque * flexible / 0.8e-3, rel=0.01
    )


@pytest.mark.physics
def test_a_long_wire_rests_on_the_plate_in_one_piece():
    world = World(240)
    add_plate_surface(world)
    long = ordered(1.6)
    model = discretise(long, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    curvature = np.where(model.spans > 0, 3.0, 0.0)
    cable.lay(np.array([0.0, 0.0, long.radius + 2e-4]), 0.3, curvature)
    for _ in range(240):
        world.step()
    nodes = cable.nodes()
    world.close()
    assert len(model.bodies) > 1
    assert np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum() == pytest.approx(1.6, abs=1e-4)
    assert np.abs(nodes[:, 2] - long.radius).max() < 5e-4


@pytest.mark.physics
def test_a_wire_that_was_cut_into_other_links_is_laid_where_it_lay():
    world = World(240)
    whole = ordered(0.6)
    cable = SimulatedWire(world, discretise(whole, world.time_step), "BU")
    angles = np.linspace(0.0, 2.0, 26)
    line = (whole.length / 2.0) * np.column_stack([np.sin(angles), 1 - np.cos(angles), 0 * angles])
    assert len(line) != len(cable.nodes())
    cable.lay_along(line)
    nodes = cable.nodes()
    world.close()
    assert np.linalg.norm(nodes[[0, -1]] - line[[0, -1]], axis=1).max() < 1e-3
    away = np.linalg.norm(nodes[:, None] - line[None], axis=2).min(axis=1)
    assert away.max() < 0.5 * whole.length / (len(line) - 1) + 1e-3


@pytest.mark.physics
def test_a_wire_rests_on_another():
    world = World(240)
    add_plate_surface(world)
    stiff = dataclasses.replace(ordered(0.36), bending_stiffness=1e-2, torsional_stiffness=8e-3)
    lower, upper = (
        SimulatedWire(world, discretise(stiff, world.time_step), colour) for colour in ("BU", "RD")
    )
    straight = np.zeros(len(lower.model.spans))
    lower.lay(np.array([0.0, -0.18, stiff.radius]), math.pi / 2, straight)
    upper.lay(np.array([-0.18, 0.0, 3 * stiff.radius + 5e-4]), 0.0, straight)
    for _ in range(480):
        world.step()
    crossing = float(np.interp(0.0, upper.nodes()[:, 0], upper.nodes()[:, 2]))
    below = float(np.abs(lower.nodes()[:, 2] - stiff.radius).max())
    world.close()
    assert crossing > 2.5 * stiff.radius
    assert below < 3e-4


@pytest.mark.physics
def test_a_wire_rests_on_a_parked_one_that_is_solid():
    def crossing_height(*additions):
        world = World(240)
        add_plate_surface(world)
        live = ordered(0.36)
        cable = SimulatedWire(world, discretise(live, world.time_step), "BU")
        line = np.linspace(-0.2, 0.2, 20)[:, None] * np.array([0.0, 1.0, 0.0])
        for add in additions:
            add(world, line + np.array([0.0, 0.0, live.radius]), live)
        start = np.array([-0.18, 0.0, 3 * live.radius + 5e-4])
        cable.lay(start, 0.0, np.zeros(len(cable.model.spans)))
        for _ in range(480):
            world.step()
        nodes = cable.nodes()
        world.close()
        return float(np.interp(0.0, nodes[:, 0], nodes[:, 2])) / live.radius

    assert crossing_height(draw_parked) == pytest.approx(1.0, abs=0.1)
    assert 2.0 < crossing_height(draw_parked, add_solid) < 3.1


@pytest.mark.physics
def test_a_parked_wire_has_no_contacts_with_what_does_not_move():
    world = World(240)
    add_plate_surface(world)
    whole = ordered(0.5)
    add_solid(world, np.linspace([0.0, 0.0, 0.0], [0.5, 0.0, 0.0], 26), whole)
    world.step()
    assert not world.bullet.getContactPoints()
    world.close()


def picture_of_parked(*additions, colour="BU"):
    """Return the picture (200, 200, 3) [0 to 255] of a wire that functions add to a world."""
    world = World(240)
    bullet = world.bullet
    line = np.linspace(-0.1, 0.1, 20)[:, None] * np.array([0.0, 1.0, 0.0])
    for add in additions:
        add(world, line, ordered(0.2, colour=colour))
    view = bullet.computeViewMatrix([0.0, 0.0, 0.2], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    lens = bullet.computeProjectionMatrixFOV(60.0, 1.0, 0.01, 1.0)
    renderer = bullet.ER_TINY_RENDERER
    _, _, rgba, _, _ = bullet.getCameraImage(200, 200, view, lens, renderer=renderer)
    world.close()
    return np.reshape(rgba, (200, 200, 4))[:, :, :3].astype(float)


def test_a_parked_wire_that_is_solid_has_the_colour_of_the_wire():
    drawn = picture_of_parked(draw_parked)
    assert np.ptp(drawn) > 100, "the wire is in view"
    assert np.abs(picture_of_parked(draw_parked, add_solid) - drawn).max() < 10


def test_a_wire_of_two_colours_has_both_in_turn_loose_and_parked_alike():
    white, blue = rgbs_of("WHBU")
    assert link_colours("WHBU", 6) == [FERRULE_RGB, white, blue, white, blue, FERRULE_RGB]
    picture = picture_of_parked(draw_parked, colour="BURD").astype(np.uint8)
    pixels = {
        colour: np.count_nonzero(wire_likelihood(picture, colour) > 0.5)
        for colour in ("BU", "RD", "BURD")
    }
    assert min(pixels["BU"], pixels["RD"]) > 0.3 * pixels["BURD"] > 50
    assert pixels["BURD"] == pytest.approx(pixels["BU"] + pixels["RD"], rel=0.1)
