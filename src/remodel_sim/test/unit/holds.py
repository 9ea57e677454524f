"""Experiments on what holds a wire, for tests and benchmarks: the grip, and a terminal's clamp."""

import dataclasses
import math

import numpy as np
from panels import component, wire

from remodel_sim.core.wire_mechanics import Piece, chain, discretise
from remodel_sim.physics.fixtures.clamps import Socket, Springs, close_clamp
from remodel_sim.physics.fixtures.panel_scene import add_clip, add_plate_surface
from remodel_sim.physics.robot import HAND_30_N, Robot
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import CONTACT_DAMPING, CONTACT_STIFFNESS, World
from remodel_work.component_shape import component_boxes
from remodel_work.edge.bullet import add_static
from remodel_work.fixtures import PLAY_M, lips_of
from remodel_work.geometry import Pose
from remodel_work.panel import PanelClip, WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN, ToolPose

# A pull grows by this share of what should hold, per second: quasi-static.
GROWTH_1_S = 0.5
# How far an end moves since the pull began when it begins to slip, and is released [m].
BEGAN_M = 0.0003
SLIPPED_M = 0.002
WAIT_LIMIT_S = 5.0
# What drives a wire through a clip: a spring, a damper and their speed.
DRIVE_N_M = 4e3
DRIVE_NS_M = 15.0
DRIVE_M_S = 0.01
# How far before the bottom an end is pushed into a spring clamp, and before that measured [m].
ALMOST_M = 0.001
GRASP_M = 0.045  # from the tip
TOOL = ToolPose(0.50, 0.0, 0.10, math.pi / 2)


def pull_out(world, cable, end, along, expected):
    """Pull an end with a growing force until it is released; return the force it held last [N]."""
    bullet, link = world.bullet, cable.ferrule(end)
    start = cable.tip(end)[0] @ along
    held = 0.0
    for step in range(math.ceil(WAIT_LIMIT_S / world.time_step)):
        force = GROWTH_1_S * expected * step * world.time_step
        apex = cable.tip(end)[0]
        bullet.applyExternalForce(
            *link, (force * along).tolist(), apex.tolist(), bullet.WORLD_FRAME
        )
        world.step()
        moved = float(cable.tip(end)[0] @ along - start)
        if moved < BEGAN_M:
            held = force
        if moved > SLIPPED_M:
            return held
    raise AssertionError(f"{force:.1f} N did not pull the end out")


def wire_in_hand(world, arm=PANDA_AT_ORIGIN, above=0.0, length=0.30, **changes):
    """Return a robot and a straight wire between its open fingers, 45 mm behind tip b.

    The wire runs along y, so far above the tool centre [m]; the fingers close along x.
    """
    robot = Robot(world, TOOL, arm)
    specimen = wire("W", ("X", "1"), ("Y", "1"), length, **changes)
    cable = SimulatedWire(world, discretise(specimen, world.time_step), "BU")
    tip = np.array([TOOL.x, GRASP_M - specimen.length, TOOL.z + above])
    cable.lay(tip, math.pi / 2, np.zeros(len(cable.model.spans)))
    return robot, cable


def grip_pull_out(grip_force, friction=0.5, rate_hz=240.0, arm=PANDA_AT_ORIGIN):
    """Grip a floating wire, pull it along itself.

    Return the force that it took, and Coulomb's [N].
    """
    world = World(rate_hz)
    world.bullet.setGravity(0, 0, 0)
    robot, cable = wire_in_hand(world, arm, friction=friction)
    robot.grip_force = grip_force
    robot.drive_fingers(0.0)
    for _ in range(round(1.5 * rate_hz)):
        world.step()
    both_sides = 2 * HAND_30_N.pad_friction * friction
    along = np.array([0.0, 1.0, 0.0])
    expected = both_sides * grip_force
    held = pull_out(world, cable, WireEnd.B, along, expected=expected)
    world.close()
    return held, expected


def clamp_pull_out(retention, rate_hz=240.0):
    """Close a terminal on an inserted end and pull; return the force it took [N]."""
    world = World(rate_hz)
    add_plate_surface(world)
    block = component("X", 1, 0.0, 0.0, side=-1, terminals=1)
    (terminal,) = block.terminals
    terminal = dataclasses.replace(terminal, retention_force=retention)
    world_from_component = Pose.level(0.5, 0.0, 0.0)
    body = add_static(world.bullet, component_boxes(block), world_from_component)
    world.bullet.changeDynamics(
        body, -1, lateralFriction=0.3,
        contactStiffness=CONTACT_STIFFNESS, contactDamping=CONTACT_DAMPING,
    )  # fmt: skip
    socket = world_from_component @ terminal.component_from_socket
    specimen = wire("W", ("X", "1"), ("Y", "1"), 0.30)
    cable = SimulatedWire(world, discretise(specimen, world.time_step), "BU")
    into = socket.rotation[:, 0]
    seated = socket.position + (terminal.depth - 2e-4) * into
    cable.lay(seated, math.atan2(-into[1], -into[0]), np.zeros(len(cable.model.spans)))
    for _ in range(round(0.5 * rate_hz)):
        world.step()
    assert close_clamp(world, cable, terminal, body, world_from_socket=socket) is not None
    held = pull_out(world, cable, WireEnd.A, -into, expected=retention)
    world.close()
    return held


def spring_forces(insertion, retention, rate_hz=240.0):
    """Push an end slowly into a spring clamp and pull it out; return the forces it took [N].

    The first is the mean on its way below the blade, before it meets the bottom.
    """
    world = World(rate_hz)
    world.bullet.setGravity(0, 0, 0)
    block = component("X", 1, 0.0, 0.0, side=-1, terminals=1)
    terminal = dataclasses.replace(
        block.terminals[0], insertion_force=insertion, retention_force=retention
    )
    world_from_component = Pose.level(0.5, 0.0, 0.0)
    body = add_static(world.bullet, component_boxes(block), world_from_component)
    at = world_from_component @ terminal.component_from_socket
    specimen = wire("W", ("X", "1"), ("Y", "1"), 0.30)
    cable = SimulatedWire(world, discretise(specimen, world.time_step), "BU")
    into = at.rotation[:, 0]
    tip = at.position + 0.5 * terminal.depth * into
    cable.lay(tip, math.atan2(-into[1], -into[0]), np.zeros(len(cable.model.spans)))
    clamps = {}
    Springs(world, cable, [WireEnd.A], [Socket(terminal, body, lambda: at)], clamps)
    forces, link = [], cable.ferrule(WireEnd.A)
    reached = start = float(cable.apex(WireEnd.A) @ into)
    bottom = float(at.position @ into) + terminal.depth - ALMOST_M
    for step in range(math.ceil(WAIT_LIMIT_S / world.time_step)):
        here = float(cable.apex(WireEnd.A) @ into)
        if here >= bottom:
            break
        speed, reached = (here - reached) / world.time_step, here
        driven = start + DRIVE_M_S * step * world.time_step
        force = DRIVE_N_M * (driven - here) + DRIVE_NS_M * (DRIVE_M_S - speed)
        if clamps and here > bottom - ALMOST_M:
            forces.append(force)
        world.bullet.applyExternalForce(
            *link, (force * into).tolist(), cable.link_pose(link)[0].tolist(),
            world.bullet.WORLD_FRAME,
        )  # fmt: skip
        world.step()
    for _ in range(round(0.5 * rate_hz)):
        world.step()
    held = pull_out(world, cable, WireEnd.A, -into, expected=retention)
    world.close()
    return float(np.mean(forces)), held


def clip_forces(retention, diameter=0.003, rate_hz=240.0):
    """Push a wire slowly into a clip and pull it out; return the largest forces on the way [N]."""
    world = World(rate_hz)
    world.bullet.setGravity(0, 0, 0)
    clip = PanelClip(
        id="C1",
        pose=(0.0, 0.0, 0.0),
        wire_diameter=diameter,
        height=0.010,
        length=0.008,
        retention_force=retention,
    )
    add_clip(world, clip, Pose.level(0.0, 0.0, 0.0))
    # Stiff, one cell in the middle of the clip; heavy, so that a stiff spring can drive it.
    specimen = wire(
        "W", ("X", "1"), ("Y", "1"), 0.06,
        diameter=diameter, bending_stiffness=1e-2, torsional_stiffness=1e-2, linear_density=0.5,
    )  # fmt: skip
    model = chain(specimen, [Piece(0.02, 0.02)] * 3, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    above = lips_of(clip).height + diameter
    cable.lay(np.array([-0.03 - diameter / 2, 0.0, above]), 0.0, np.zeros(2))
    inward = _drive(world, cable, above, clip.height)
    for _ in range(round(0.2 * rate_hz)):
        world.step()
    rests = float(cable.link_pose(_middle(cable))[0][2])
    assert abs(rests - clip.height) < 2 * PLAY_M, f"it rests at {rests:.4f} m"
    outward = _drive(world, cable, rests, above)
    world.close()
    return inward, outward


def _middle(cable):
    return cable.bodies[0], 0


def _drive(world, cable, start, end):
    """Move the middle link by a spring from one height to another; return its largest force."""
    bullet, sign = world.bullet, math.copysign(1.0, end - start)
    steps = math.ceil(abs(end - start) / (DRIVE_M_S * world.time_step))
    largest = 0.0
    for step in range(1, steps + 1):
        at = cable.link_pose(_middle(cable))[0]
        velocity = bullet.getLinkState(*_middle(cable), computeLinkVelocity=1)[6][2]
        target = start + sign * step * DRIVE_M_S * world.time_step
        force = DRIVE_N_M * (target - at[2]) + DRIVE_NS_M * (sign * DRIVE_M_S - velocity)
        bullet.applyExternalForce(
            *_middle(cable), [0.0, 0.0, force], at.tolist(), bullet.WORLD_FRAME
        )
        world.step()
        largest = max(largest, sign * force)
    return largest
