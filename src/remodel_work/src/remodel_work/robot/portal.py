"""Kinematics of a portal: three linear axes carry a hand over the plate, and turn it.

The hand hangs from a ram, so that nothing but the ram stands above what it works on: a portal
reaches between devices and into ducts where the links of an arm would be in the way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.robot.arm import LinearAxis, ToolPose
from remodel_work.robot.fingers import Fingers

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
