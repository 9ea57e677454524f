"""The fingers of a cell's file in the physics: where they end, what they grip and lead."""

import math
from dataclasses import replace

import numpy as np
import pytest
from holds import TOOL, wire_in_hand
from panels import wire

from remodel_sim.physics.robot import Robot
from remodel_sim.physics.wires.parked_wire import add_solid
from remodel_sim.physics.world import CONTACT_STIFFNESS, GRAVITY, MASS_SCALE, World
from remodel_work.component_shape import Box
from remodel_work.edge.bullet import add_static
from remodel_work.edge.cell_file import read_cell
from remodel_work.edge.robot_description import FINGERS, SHEATHS
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN

(CABINET,) = read_cell("cabinet").robots
SLIM = CABINET.arm
# Of the cell that tucks wires in: flush above the eyelet.
FLUSH = read_cell("two_arms_cabinet").robots[0].arm
# Pads that are so near to each other have closed.
SHUT_M = 0.0008
# What the pads yield to a grip of 30 N, both sides together: the contacts' stiffness.
YIELDS_M = 2 * 30.0 / CONTACT_STIFFNESS
# Two thirds of what the friction of a grip of 30 N holds, and far less.
HELD_N = 20.0
SLIDES_N = 1.0
# A wire that springs aside in an open hand, and is held back as the hand rises; its radius.
OUTWARD_N, DOWN_N = 0.05, 0.5
WIRE_RADIUS_M = 0.0015
# It sprang so far above the tool [m]; pads that end below it leave a ledge before the stem [m].
SPRUNG_UP_M = 0.028
LEDGE_PAD_M = 0.0274
# A hand goes so far [m], as fast as one that leads a wire [m/s].
SWEEP_M = 0.15
SWEEP_SPEED = 0.25


def height_in_hand(cable):
    """Return the height of a wire's middle between the fingers above the tool centre [m]."""
    nodes = cable.nodes()
    return float(np.interp(TOOL.y, nodes[:, 1], nodes[:, 2])) - TOOL.z


def pull(world, cable, force, steps):
    """Pull at tip b along the wire [N]; return where the tip was before, (3,) [m]."""
    before = cable.tip(WireEnd.B)[0]
    for _ in range(steps):
        link, tip = cable.ferrule(WireEnd.B), cable.tip(WireEnd.B)[0]
        bullet = world.bullet
        bullet.applyExternalForce(*link, [0.0, force, 0.0], tip.tolist(), bullet.WORLD_FRAME)
        world.step()
    return before


def tip_boxes(world, robot):
    """Return the corners of both fingers' boxes about the tool centre, (n, 3) [m], hand's axes."""
    bullet = world.bullet
    hand, corners = robot.world_from_hand, []
    for link in range(bullet.getNumJoints(robot.body)):
        if bullet.getJointInfo(robot.body, link)[12].decode() not in FINGERS:
            continue
        state = bullet.getLinkState(robot.body, link, computeForwardKinematics=True)
        for shape in bullet.getCollisionShapeData(robot.body, link):
            place = bullet.multiplyTransforms(*state[:2], shape[5], shape[6])
            signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
            turned = np.array(bullet.getMatrixFromQuaternion(place[1])).reshape(3, 3)
            corners.append(np.array(place[0]) + signs * shape[3] @ turned.T)
    points = hand.inverse().apply(np.concatenate(corners))
    return points - [0.0, 0.0, robot.arm.fingers.tool_m]


@pytest.mark.parametrize("arm", [PANDA_AT_ORIGIN, SLIM])
def test_the_tips_are_as_wide_and_reach_as_far_as_the_data_says(arm):
    world, fingers = World(240), arm.fingers
    points = tip_boxes(world, Robot(world, TOOL, arm))
    np.testing.assert_allclose(points[:, 2].max(), fingers.below, atol=1e-6)
    bevel = 0.0 if fingers.eyelet is None else fingers.eyelet.bevel
    tips = points[points[:, 2] > bevel - fingers.below]
    np.testing.assert_allclose(np.abs(tips[:, 0]).max(), fingers.width / 2, atol=1e-6)
    np.testing.assert_allclose(np.abs(tips[:, 1]).min(), fingers.opening / 2, atol=1e-6)
    tip_outer, stem_outer = fingers.thickness, fingers.stem.behind + fingers.stem.thickness
    np.testing.assert_allclose(np.abs(tips[:, 1]).max(), fingers.opening / 2 + tip_outer, atol=1e-6)
    outer = fingers.opening / 2 + max(tip_outer, stem_outer)
    np.testing.assert_allclose(np.abs(points[:, 1]).max(), outer, atol=1e-6)
    world.close()


@pytest.mark.physics
@pytest.mark.parametrize("diameter", [0.003, 0.006])
def test_slim_pads_grip_wires_of_all_thicknesses(diameter):
    world = World(240)
    robot, cable = closed_on_a_wire(world, diameter, above=0.0)
    assert robot.finger_gap == pytest.approx(diameter - YIELDS_M, abs=3e-4)
    assert robot.finger_load > 20.0
    assert abs(height_in_hand(cable)) < 0.001
    before = pull(world, cable, HELD_N, steps=120)
    assert cable.tip(WireEnd.B)[0][1] - before[1] < 0.0005, "the wire slips"
    world.close()


@pytest.mark.physics
@pytest.mark.parametrize("diameter", [0.003, 0.006])
def test_a_closed_eyelet_keeps_a_wire_from_dropping_out_and_lets_it_slide(diameter):
    world, eyelet = World(240), SLIM.fingers.eyelet
    robot, cable = closed_on_a_wire(world, diameter, above=eyelet.above)
    assert robot.finger_gap < SHUT_M
    away = abs(height_in_hand(cable) - eyelet.above)
    assert away < eyelet.height / 2, "the wire left the eyelet"
    before = pull(world, cable, SLIDES_N, steps=120)
    assert cable.tip(WireEnd.B)[0][1] - before[1] > 0.01, "the wire does not slide"
    world.close()


def hold_back(arm, above, aside):
    """Lay a wire across an open hand, beside a finger; return how high it is, held back [m].

    Args:
        arm: with its fingers.
        above: the tool centre [m].
        aside: of the middle between the fingers [m].
    """
    world = World(240)
    world.bullet.setGravity(0, 0, 0)
    _, cable = wire_in_hand(world, arm, above=above)
    start = cable.nodes()[0] + [aside, 0.0, 0.0]
    cable.lay(start, math.pi / 2, np.zeros(len(cable.model.spans)))
    links = [(body, i) for body in cable.bodies for i in range(world.bullet.getNumJoints(body))]
    middle = min(links, key=lambda link: abs(cable.link_pose(link)[0][1] - TOOL.y))
    for _ in range(240):
        at, force = cable.link_pose(middle)[0].tolist(), [OUTWARD_N, 0.0, -DOWN_N]
        world.bullet.applyExternalForce(*middle, force, at, world.bullet.WORLD_FRAME)
        world.step()
    height = height_in_hand(cable)
    world.close()
    return height


@pytest.mark.physics
@pytest.mark.parametrize(("bevel", "slides_off"), [(SLIM.fingers.eyelet.bevel, True), (0.0, False)])
def test_a_wire_in_the_notch_of_an_open_finger_slides_off_its_bevel(bevel, slides_off):
    eyelet = replace(SLIM.fingers.eyelet, bevel=bevel)
    fingers = replace(SLIM.fingers, eyelet=eyelet)
    in_notch = fingers.opening / 2 + eyelet.depth - WIRE_RADIUS_M
    height = hold_back(replace(SLIM, fingers=fingers), eyelet.above, in_notch)
    lip = eyelet.above - eyelet.height / 2
    assert (height < lip - bevel) == slides_off


@pytest.mark.physics
@pytest.mark.parametrize(
    ("pad_height", "slides_off"), [(FLUSH.fingers.pad_height, True), (LEDGE_PAD_M, False)]
)
def test_a_wire_that_sprang_up_between_open_fingers_finds_no_ledge_to_lie_on(
    pad_height, slides_off
):
    fingers = replace(FLUSH.fingers, pad_height=pad_height)
    behind = 0.0 if slides_off else fingers.stem.behind
    beside_finger = fingers.opening / 2 + behind - WIRE_RADIUS_M
    height = hold_back(replace(FLUSH, fingers=fingers), SPRUNG_UP_M, beside_finger)
    assert (height < fingers.eyelet.above) == slides_off


@pytest.mark.physics
def test_empty_fingers_stop_where_their_pads_meet():
    world = World(240)
    robot = Robot(world, TOOL, SLIM)
    robot.drive_fingers(0.0)
    for _ in range(240):
        world.step()
    assert robot.finger_gap < SHUT_M
    world.close()


def parked_across(world):
    """Park a wire across the way of a hand that goes along x, in front of the pads."""
    middle = np.array([TOOL.x + SWEEP_M / 2, TOOL.y, TOOL.z])
    line = middle + np.linspace(-0.1, 0.1, 11)[:, None] * np.array([0.0, 1.0, 0.0])
    add_solid(world, line, wire("W", ("X", "1"), ("Y", "1"), 0.2))


def most_felt(add):
    """Sweep the hand along x; return the most that its wrist feels more than at rest, level [N]."""
    world = World(240)
    robot = Robot(world, TOOL, SLIM)
    add(world)
    for _ in range(60):
        world.step()
    still, most = robot.wrist_force, 0.0
    per_command, commands = 2, round(SWEEP_M / SWEEP_SPEED * 120)
    for command in range(1, commands + 1):
        ahead = SWEEP_M * command / commands
        robot.drive(SLIM.joints_for(replace(TOOL, x=TOOL.x + ahead)), per_command)
        for _ in range(per_command):
            world.step()
            felt = robot.world_from_hand.rotation @ (robot.wrist_force - still)
            # Once it is at its speed.
            if command > commands / 4:
                most = max(most, float(np.linalg.norm(felt[:2])))
    world.close()
    return most


@pytest.mark.physics
def test_a_hand_in_motion_feels_nothing_but_what_it_touches():
    assert most_felt(lambda world: None) < 0.5


@pytest.mark.physics
def test_a_hand_pushes_against_a_parked_wire_which_yields():
    # A few times what 220 N/m make of the half of a finger: the servos drive on.
    assert 1.0 < most_felt(parked_across) < 10.0


@pytest.mark.physics
def test_nothing_else_touches_what_parked_wires_touch():
    world = World(240)
    robot = Robot(world, TOOL, SLIM)
    bullet = world.bullet
    links = [bullet.getJointInfo(robot.body, i)[12] for i in range(bullet.getNumJoints(robot.body))]
    sheaths = [links.index(sheath.encode()) for sheath in SHEATHS]
    aside = (SLIM.fingers.opening + SLIM.fingers.thickness) / 2
    box = Box((0.0, 0.0, 0.0), (0.005, 0.2, 0.005), (1.0, 1.0, 1.0))
    add_static(bullet, [box], Pose.level(TOOL.x + aside, TOOL.y, TOOL.z))
    world.step()
    touched = {contact[3] for contact in bullet.getContactPoints(bodyA=robot.body)}
    assert touched and not touched & set(sheaths)
    world.close()


def closed_on_a_wire(world, diameter, above):
    """Return a robot whose fingers have closed on a wire so far above the tool centre [m]."""
    world.bullet.setGravity(0, 0, 0)
    robot, cable = wire_in_hand(world, SLIM, above=above, diameter=diameter)
    robot.drive_fingers(0.0)
    for _ in range(120):
        world.step()
    world.bullet.setGravity(0, 0, -GRAVITY / MASS_SCALE)
    for _ in range(240):
        world.step()
    return robot, cable
