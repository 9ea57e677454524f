"""A wire that is pulled around a post, for tests and benchmarks."""

import math

import numpy as np
from panels import wire

from remodel_sim.core.workpiece.panel import WireEnd
from remodel_sim.core.workpiece.wire_mechanics import discretise
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World

RADIUS_M = 0.060
FRICTION = 0.5
# The wire is laid around the post in so much wider an arc [m], and then pulled taut.
ROOM_M = 0.010
BACK_N = 2.0
SPEED_M_S = 0.04
TAUT_S = 1.0
MEASURED_S = 3.0


def capstan(length, rate_hz=240.0):
    """Pull a wire by a quarter turn around a post; return the measured and Euler's force ratio."""
    specimen = wire("W", ("X", "1"), ("Y", "1"), length, friction=FRICTION, yield_curvature=1e6)
    world = World(rate_hz)
    bullet = world.bullet
    bullet.setGravity(0, 0, 0)
    shape = bullet.createCollisionShape(bullet.GEOM_CYLINDER, radius=RADIUS_M, height=0.1)
    post = bullet.createMultiBody(0, shape)
    bullet.changeDynamics(post, -1, lateralFriction=1.0)
    cable = SimulatedWire(world, discretise(specimen, world.time_step), "BU")
    cable.lay_along(_around(cable, RADIUS_M + specimen.radius + ROOM_M))
    (body, link), back = cable.ferrule(WireEnd.A), cable.ferrule(WireEnd.B)
    position, quaternion = cable.link_pose((body, link))
    pull = bullet.createConstraint(
        body, link, -1, -1, bullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], position.tolist(),
        [0, 0, 0, 1], quaternion.tolist(),
    )  # fmt: skip
    forces = []
    for step in range(round((TAUT_S + MEASURED_S) * rate_hz)):
        position[0] -= SPEED_M_S / rate_hz
        bullet.changeConstraint(pull, position.tolist(), quaternion.tolist(), maxForce=1e3)
        tip = cable.tip(WireEnd.B)[0].tolist()
        bullet.applyExternalForce(*back, [0, BACK_N, 0], tip, bullet.WORLD_FRAME)
        world.step()
        if step >= TAUT_S * rate_hz:
            forces.append(np.linalg.norm(bullet.getConstraintState(pull)[:3]))
    world.close()
    return float(np.mean(forces)) / BACK_N, math.exp(FRICTION * math.pi / 2)


def _around(cable, radius):
    """Return nodes along +x, a quarter around the origin, and along +y."""
    steps = cable.model.lengths.copy()
    steps[[0, -1]] += cable.model.radius
    arc = math.pi / 2 * radius
    straight = (float(steps.sum()) - arc) / 2
    along = np.r_[np.linspace(0.0, straight, 500), np.linspace(straight, straight + arc, 500)]
    along = np.r_[along, np.linspace(straight + arc, 1.01 * float(steps.sum()), 500)]
    turned = np.clip((along - straight) / radius, 0.0, math.pi / 2)
    before, after = np.minimum(along - straight, 0.0), np.maximum(along - straight - arc, 0.0)
    line = np.column_stack(
        [radius * np.sin(turned) + before, after - radius * np.cos(turned), 0.0 * along]
    )
    nodes, at = [line[0]], 0.0
    for step in steps:
        low, high = at, along[-1]
        for _ in range(50):
            middle = (low + high) / 2
            point = np.array([np.interp(middle, along, axis) for axis in line.T])
            short = np.linalg.norm(point - nodes[-1]) < step
            low, high = (middle, high) if short else (low, middle)
        nodes.append(point)
        at = low
    return np.array(nodes)
