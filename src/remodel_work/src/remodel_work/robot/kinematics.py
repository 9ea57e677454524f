"""Kinematics of what carries a tool: arms on fixed bases, on a linear axis, and portals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import Fingers


class Kinematics(Protocol):
    """A robot in its place; `Arm` and `Portal` are."""

    @property
    def base(self) -> tuple[float, float, float, float]:
        """(x, y, z) [m] and yaw [rad] of its base in the world."""

    @property
    def fingers(self) -> Fingers:
        """On its hand."""

    @property
    def axis(self) -> LinearAxis | None:
        """The axis that carries the base; None: it is bolted down."""

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of all joints, (joints,) each [m, rad]."""

    @property
    def speeds(self) -> Array:
        """Greatest speeds of all joints, (joints,) [m/s, rad/s]; the last one turns the hand."""

    @property
    def world_from_base(self) -> Pose:
        """Where its base stands."""

    def joints_for(self, tool: ToolPose) -> Array:
        """Return the joints (joints,) for a tool pose; raises UNREACHABLE."""

    def reaches(self, tool: ToolPose) -> bool:
        """Return whether it reaches a tool pose."""

    def tool_of(self, joints: Array) -> ToolPose:
        """Return the tool pose of a posture, (joints,)."""

    def canonical_yaw(self, x: float, y: float, yaw: float) -> float | None:
        """Return the tool's yaw as the value for which its last joint is linear, or None."""

    def last_joint(self, x: float, y: float, canonical: float) -> float:
        """Return the last joint [rad] for a canonical yaw at a place."""


# The rule's corners are rounded over about so much of the tool's way [m].
ROUNDING_M = 0.06


@dataclass(frozen=True)
class LinearAxis:
    """An axis along y of the arm's base.

    Attributes:
        lower, upper: limits of its position [m]; at 0 the arm stands where its base is given.
        speed: it moves no faster [m/s].
    """

    lower: float
    upper: float
    speed: float

    def position_for(self, x: float, y: float, near: float) -> float:
        """Return the axis's position for a place of the tool in the base's frame [m].

        `near`: the arm reaches what is so far away or further [m]. The hypotenuse over x and the
        step aside, near * sqrt(2) - x, is never shorter.
        """
        aside = _positive_part(near * math.sqrt(2.0) - x)
        position = y + (aside if self.upper > -self.lower else -aside)
        position = self.upper - _positive_part(self.upper - position)
        position = self.lower + _positive_part(position - self.lower)
        return min(self.upper, position)


def _positive_part(value: float) -> float:
    """Return a value [m] where it is positive and zero elsewhere, rounded near zero."""
    return (value + math.hypot(value, ROUNDING_M)) / 2


JOINT_NAMES = ("portal_x", "portal_y", "portal_z", "portal_turn")
# The hand turns by so much to either side of the base's yaw [rad]: it follows a wire around corners
# that are a full turn together, whichever way round it begins.
TURN_RAD = 2.5 * math.pi
# Linear axes driven by belts go faster, and so do rotary ones [m/s, rad/s].
AXIS_SPEED = 1.5
TURN_RATE = 4.0


@dataclass(frozen=True)
class Portal:
    """A portal in its place; joints are x, y and z [m] along its base's axes, and a turn [rad].

    Attributes:
        base: (x, y, z) [m] and yaw [rad] of the tool in the world where all joints are at zero.
        lower, upper: limits of x, y and z, (3,) each [m].
        fingers: on the Panda's hand, which it carries.
    """

    base: tuple[float, float, float, float]
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    fingers: Fingers

    @property
    def axis(self) -> LinearAxis | None:
        """It stands on none."""
        return None

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of all joints, (4,) each."""
        return np.array([*self.lower, -TURN_RAD]), np.array([*self.upper, TURN_RAD])

    @property
    def speeds(self) -> Array:
        """Greatest speeds of all joints, (4,) [m/s, rad/s]."""
        return np.array([*[AXIS_SPEED] * 3, TURN_RATE])

    @property
    def world_from_base(self) -> Pose:
        """Where the tool is when all joints are at zero."""
        return Pose.level(*self.base)

    def joints_for(self, tool: ToolPose) -> Array:
        """Return the joints (4,) for a tool pose.

        Raises:
            AbilityError: UNREACHABLE, with the joint that stands against it.
        """
        place = self.world_from_base.inverse().apply(tool.position)
        joints = np.array([*place, self._turn(tool.yaw)])
        lower, upper = self.limits
        beyond = np.flatnonzero((joints < lower) | (joints > upper))
        if beyond.size:
            i = int(beyond[0])
            raise AbilityError(
                Code.UNREACHABLE,
                f"the portal does not reach {tool}: {JOINT_NAMES[i]} would stand at "
                f"{joints[i]:.3f}, allowed {lower[i]:.3f} to {upper[i]:.3f}",
            )
        return joints

    def reaches(self, tool: ToolPose) -> bool:
        """Return whether it reaches a tool pose."""
        try:
            self.joints_for(tool)
        except AbilityError:
            return False
        return True

    def tool_of(self, joints: Array) -> ToolPose:
        """Return the tool pose of a posture, (4,)."""
        x, y, z = (float(v) for v in self.world_from_base.apply(joints[:3]))
        return ToolPose(x, y, z, self.base[3] + float(joints[3]))

    def canonical_yaw(self, x: float, y: float, yaw: float) -> float | None:
        """Return the tool's yaw as it is, or turned by 2 pi where it is beyond the turn's limit."""
        return self.base[3] + self._turn(yaw)

    def last_joint(self, x: float, y: float, canonical: float) -> float:
        """Return the turn [rad] for a canonical yaw."""
        return canonical - self.base[3]

    def _turn(self, yaw: float) -> float:
        """Return the turn [rad] for a yaw."""
        turn = yaw - self.base[3]
        return turn if abs(turn) <= TURN_RAD else float(wrap_angle(turn))
