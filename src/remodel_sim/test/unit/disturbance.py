"""Disturb where arms and wires begin by less than any sensor shows, for `--disturb SEED`."""

from contextlib import contextmanager

import numpy as np

from remodel_sim.physics.robot import Robot
from remodel_sim.physics.wires.cable import SimulatedWire

# How far places [m] and angles [rad] are off: the spread of the disturbance.
SPREAD = 1e-9


@contextmanager
def disturbed(seed):
    """Begin each arm's joints, and each wire where it is laid, a little beside their places."""
    random = np.random.default_rng(seed)
    make, lay, lay_along = Robot.__init__, SimulatedWire.lay, SimulatedWire.lay_along

    def off(values):
        return values + SPREAD * random.standard_normal(np.shape(values))

    def make_off(robot, world, *args, **options):
        make(robot, world, *args, **options)
        for joint, place in zip(robot._joints, off(robot.joints), strict=True):
            world.bullet.resetJointState(robot.body, joint, place)

    def lay_off(wire, tip_a, yaw, curvature):
        lay(wire, off(tip_a), float(off(yaw)), curvature)

    def lay_along_off(wire, nodes):
        lay_along(wire, off(nodes))

    Robot.__init__ = make_off
    SimulatedWire.lay, SimulatedWire.lay_along = lay_off, lay_along_off
    try:
        yield
    finally:
        Robot.__init__ = make
        SimulatedWire.lay, SimulatedWire.lay_along = lay, lay_along
