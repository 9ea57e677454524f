"""Admittance control of a push or pull: the speed falls with the force against the motion.

What stops a tool that moves on at v raises the force by K v dt with every step of the control. So
the speed is the force that is missing, over K T: then a stop of stiffness K or less raises the
force towards its limit within some T, and does not exceed it, as long as T is longer than a step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.parameters import MotionParameters
from remodel_work.geometry import Array


@dataclass(frozen=True)
class ForceControl:
    """The control of one push or pull.

    Attributes:
        limit: the force that it comes to and keeps [N].
        stiffness: of the stiffest thing that may stop it, with what holds it [N/m].
        motion: its time constant, and how fast it speeds up.
    """

    limit: float
    stiffness: float
    motion: MotionParameters

    def speed(self, wanted: float, force: float, before: float, time_step: float) -> float:
        """Return the speed of the next step [m/s], negative for backwards.

        Args:
            wanted: speed where nothing resists [m/s].
            force: against the motion [N].
            before: speed of the step before [m/s].
            time_step: [s].
        """
        motion = self.motion
        missing = (1 + motion.force_aims_above_share) * self.limit - force
        allowed = missing / (self.stiffness * motion.force_time_constant_s)
        return min(wanted, allowed, before + motion.force_acceleration_m_s2 * time_step)


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
    stiffness: float

    def speeds(
        self, forces: Array, before: Array, time_step: float, motion: MotionParameters
    ) -> Array:
        """Return the speeds of the next step, (k,) [m/s].

        Args:
            forces: of the tool on what it touches, (k,) [N].
            before: speeds of the step before, (k,) [m/s].
            time_step: [s].
            motion: the time constant, and how fast the tool speeds up.
        """
        wanted = -forces / (self.stiffness * motion.force_time_constant_s)
        change = motion.force_acceleration_m_s2 * time_step
        return np.clip(wanted, before - change, before + change)


# A motion that gives way nowhere.
RIGID = Yielding(np.zeros((0, 3)), np.zeros(0), math.inf)


class ForceLoop:
    """A push or pull under force control, step by step of the arm's controller.

    A skill sets at each tick where it leads and how fast; the controller takes the joints of each
    of its own steps from it, or does the same by itself.

    Attributes:
        along: unit vector of the motion, (3,), world frame.
        control: its limit.
        free: what the wrist feels of a hand that touches nothing, (3,) [N], world frame.
        hand_mass: what the wrist carries [kg].
        yielding: how it gives way across the motion.
        elapsed_s: since the start, by the steps that the controller has made [s].
        travel: from the start, along the motion [m].
        aside: how far it gave way along each direction of `yielding`, (k,) [m].
        peak: the largest force so far, of each step, not filtered [N].
        pressed_at: travel at which the force first came near its limit [m]; None:
            it has not yet.
    """

    def __init__(self, along: Array, control: ForceControl, free: Array, hand_mass: float) -> None:
        """Prepare a motion that gives way nowhere."""
        self.along, self.control, self.free, self.hand_mass = along, control, free, hand_mass
        self.yielding, self.aside = RIGID, np.zeros(0)
        self.elapsed_s = self.travel = self.peak = 0.0
        self.pressed_at: float | None = None
        self._speed = self._acceleration = 0.0
        self._aside_speed = self._aside_acceleration = np.zeros(0)

    def yield_to(self, yielding: Yielding) -> None:
        """Give way to forces across the motion from now on."""
        self.yielding = yielding
        self.aside = np.zeros(len(yielding.most))
        self._aside_speed = self._aside_acceleration = np.zeros(len(yielding.most))

    def begin_tick(
        self, joints: Array, turn: Array, aside_turns: Array, *, reach: float, speed: float
    ) -> None:
        """Say where the next tick leads.

        Args:
            joints: where the tool is now, (joints,).
            turn: from there to `reach` further on, (joints,).
            aside_turns: for each direction of `yielding`, (k, joints) [1/m].
            reach: how far the tick may lead, forth or back [m].
            speed: of the motion where nothing resists [m/s].
        """
        self._joints, self._turn, self._aside_turns = joints, turn, aside_turns
        self._reach, self._wanted = reach, speed
        self._from, self._aside_from = self.travel, self.aside

    def step(self, wrist_force: Array, time_step: float) -> Array:
        """Return the joints of the controller's next step, (joints,).

        Args:
            wrist_force: in the last step, not filtered, (3,) [N], world frame.
            time_step: [s].
        """
        self.elapsed_s += time_step
        all_felt = wrist_force - self.free
        felt = float(all_felt @ self.along)
        force = felt - self.hand_mass * self._acceleration
        self.peak = max(self.peak, force)
        pressed = self.control.motion.force_pressed_share
        if self.pressed_at is None and force >= pressed * self.control.limit:
            self.pressed_at = self.travel
        speed = self.control.speed(self._wanted, force, self._speed, time_step)
        travel = self.travel + speed * time_step
        travel = float(np.clip(travel, self._from - self._reach, self._from + self._reach))
        reached = (travel - self.travel) / time_step
        self._acceleration = (reached - self._speed) / time_step
        self.travel, self._speed = travel, reached
        aside = self._give_way(all_felt, time_step) @ self._aside_turns
        return self._joints + (travel - self._from) / self._reach * self._turn + aside

    def _give_way(self, felt: Array, time_step: float) -> Array:
        """Give way across the motion for a step; return how far since the tick began, (k,) [m]."""
        yielding, before = self.yielding, self._aside_speed
        forces = yielding.directions @ felt - self.hand_mass * self._aside_acceleration
        speeds = yielding.speeds(forces, before, time_step, self.control.motion)
        aside = np.clip(self.aside + speeds * time_step, -yielding.most, yielding.most)
        self._aside_speed = (aside - self.aside) / time_step
        self._aside_acceleration = (self._aside_speed - before) / time_step
        self.aside = aside
        return aside - self._aside_from
