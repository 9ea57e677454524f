"""Kinematics of a Franka Panda that works on a level panel: the tool always points straight down.

With joints 3 and 5 at zero the arm moves in one vertical plane through its base, turned by joint 1.
Then a downward tool is a planar two-link problem with one solution (elbow up), and joint 7 sets the
tool's yaw alone. Lengths: https://frankaemika.github.io/docs/control_parameters.html.

  upper link  shoulder to elbow: 0.316 along, 0.0825 across
  fore link   elbow to wrist: 0.384 along, -0.0825 across
  wrist       0.088 outward to the flange axis, then 0.107 down to the flange
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array, wrap_angle

SHOULDER_HEIGHT_M = 0.333
UPPER_M = math.hypot(0.316, 0.0825)
UPPER_RAD = math.atan2(0.0825, 0.316)
FORE_M = math.hypot(0.384, 0.0825)
FORE_RAD = math.atan2(0.0825, 0.384)
WRIST_OFFSET_M = 0.088
FLANGE_M = 0.107
# Hand and own fingers: from the flange to the middle of the wire in the grip
# (physics/robot_description.py builds them so).
TOOL_M = 0.129

# Soft limits of joints 1 to 7 [rad], from the same page.
LOWER_RAD = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
UPPER_LIMIT_RAD = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])


@dataclass(frozen=True)
class ToolPose:
    """The tool centre with the tool pointing down; world frame.

    Attributes:
        x, y, z: tool centre [m].
        yaw: direction of the hand's x axis [rad]; the fingers close across it. Not wrapped: a path
            turns from one value to the next the way the numbers say.
    """

    x: float
    y: float
    z: float
    yaw: float

    @property
    def position(self) -> Array:
        """The tool centre, (3,) [m]."""
        return np.array([self.x, self.y, self.z])

    def at(self, *, z: float) -> ToolPose:
        """Return the same pose at another height."""
        return ToolPose(self.x, self.y, z, self.yaw)

    def __str__(self) -> str:
        """Show millimetres and degrees."""
        return (
            f"x {self.x * 1e3:.0f}, y {self.y * 1e3:.0f}, z {self.z * 1e3:.0f} mm, "
            f"yaw {math.degrees(wrap_angle(self.yaw)):.0f} deg"
        )


def joints_for(tool: ToolPose) -> Array:
    """Return the arm's joint angles (7,) [rad] for a tool pose.

    Raises:
        AbilityError: UNREACHABLE, with the joint or distance that stands against it.
    """
    azimuth = math.atan2(tool.y, tool.x)
    out = math.hypot(tool.x, tool.y) - WRIST_OFFSET_M
    up = tool.z + TOOL_M + FLANGE_M - SHOULDER_HEIGHT_M
    distance = math.hypot(out, up)
    cosine = (distance**2 - UPPER_M**2 - FORE_M**2) / (2 * UPPER_M * FORE_M)
    if not -1.0 <= cosine <= 1.0:
        raise AbilityError(
            Code.UNREACHABLE,
            f"no arm posture reaches {tool}: the wrist would be {distance:.3f} m from the "
            "shoulder, "
            f"the arm spans at most {UPPER_M + FORE_M:.3f} m",
        )
    bend = math.acos(cosine)
    lean = math.atan2(out, up) - math.atan2(
        FORE_M * math.sin(bend), UPPER_M + FORE_M * math.cos(bend)
    )
    q2 = lean - UPPER_RAD
    q4 = -(bend + UPPER_RAD + FORE_RAD)
    q6 = q2 - q4
    q7 = wrap_angle(azimuth + math.pi / 4 - tool.yaw)
    joints = np.array([azimuth, q2, 0.0, q4, 0.0, q6, q7])
    beyond = np.flatnonzero((joints < LOWER_RAD) | (joints > UPPER_LIMIT_RAD))
    if beyond.size:
        i = int(beyond[0])
        raise AbilityError(
            Code.UNREACHABLE,
            f"no arm posture reaches {tool}: joint {i + 1} would stand at {joints[i]:.2f} rad, "
            f"allowed {LOWER_RAD[i]:.2f} to {UPPER_LIMIT_RAD[i]:.2f}",
        )
    return joints


def canonical_yaw(x: float, y: float, yaw: float) -> float | None:
    """Return the tool's yaw as the value for which joint 7 is linear, or None beyond its limits.

    Two canonical yaws differ by the turn that joint 7 really makes, be it the long way round.
    """
    azimuth = math.atan2(y, x)
    q7 = wrap_angle(azimuth + math.pi / 4 - yaw)
    if not LOWER_RAD[6] <= q7 <= UPPER_LIMIT_RAD[6]:
        return None
    return azimuth + math.pi / 4 - q7


def reaches(tool: ToolPose) -> bool:
    """Return whether the arm reaches a tool pose within its joint limits."""
    try:
        joints_for(tool)
    except AbilityError:
        return False
    return True


def tool_of(joints: Array) -> ToolPose:
    """Return the tool pose of a downward posture (joints 3 and 5 at zero), (7,) [rad]."""
    q1, q2, _, q4, _, _, q7 = joints
    fore = q2 - q4
    out = WRIST_OFFSET_M + UPPER_M * math.sin(q2 + UPPER_RAD) + FORE_M * math.sin(fore - FORE_RAD)
    up = SHOULDER_HEIGHT_M + UPPER_M * math.cos(q2 + UPPER_RAD) + FORE_M * math.cos(fore - FORE_RAD)
    return ToolPose(
        out * math.cos(q1), out * math.sin(q1), up - FLANGE_M - TOOL_M, q1 + math.pi / 4 - q7
    )
