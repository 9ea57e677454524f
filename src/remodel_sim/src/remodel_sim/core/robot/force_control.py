"""Admittance control of a push or pull: the speed falls with the force against the motion.

What stops a tool that moves on at v raises the force by K v dt with every step of the control. So
the speed is the force that is missing, over K T: then a stop of stiffness K or less raises the
force towards its limit within some T, and does not exceed it, as long as T is longer than a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_work.geometry import Array

# A wire in the grip, at the bottom of its terminal or in its clamp, gives by 1 mm at 60 N [N/m].
WIRE_STIFFNESS = 6e4
# T: three steps of 240 Hz, the slowest rate of the physics. With two, what is damped at a stop, a
# ferrule flat on a bottom with some 700 N s/m, exceeds the limit by 40 % in the first step.
TIME_CONSTANT_S = 0.012
# The control aims above the limit by this share, so that the limit is reached.
AIMS_ABOVE = 0.05
# Faster, and the force that speeds the hand up would count as a push [m/s^2].
ACCELERATION = 0.3


@dataclass(frozen=True)
class ForceControl:
    """The control of one push or pull.

    Attributes:
        limit: the force that it comes to and keeps [N].
        stiffness: of the stiffest thing that may stop it, with what holds it [N/m].
    """

    limit: float
    stiffness: float = WIRE_STIFFNESS

    def speed(self, wanted: float, force: float, before: float, time_step: float) -> float:
        """Return the speed of the next step [m/s], negative for backwards.

        Args:
            wanted: speed where nothing resists [m/s].
            force: against the motion [N].
            before: speed of the step before [m/s].
            time_step: [s].
        """
        missing = (1 + AIMS_ABOVE) * self.limit - force
        allowed = missing / (self.stiffness * TIME_CONSTANT_S)
        return min(wanted, allowed, before + ACCELERATION * time_step)


@dataclass(frozen=True, eq=False)
class Yielding:
    """How a tool gives way to forces across its motion.

    A wire that lies askew in the grip leans on the opening that its end is pushed into: the hand
    gives way until it does not, rather than bending it.

    Attributes:
        directions: (k, 3) unit vectors, square to the motion and to each other.
        most: (k,) how far it gives way along each, to either side [m].
        stiffness: with which the forces grow, at most [N/m].
    """

    directions: Array
    most: Array
    stiffness: float = WIRE_STIFFNESS

    def speeds(self, forces: Array, before: Array, time_step: float) -> Array:
        """Return the speeds of the next step, (k,) [m/s].

        Args:
            forces: of the tool on what it touches, (k,) [N].
            before: speeds of the step before, (k,) [m/s].
            time_step: [s].
        """
        wanted = -forces / (self.stiffness * TIME_CONSTANT_S)
        change = ACCELERATION * time_step
        return np.clip(wanted, before - change, before + change)
