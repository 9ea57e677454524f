"""What an ability needs to know of a robot that points its tool down, of whatever build."""

from __future__ import annotations

from typing import Protocol

from remodel_work.geometry import Array, Pose
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import Fingers
from remodel_work.robot.linear_axis import LinearAxis


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
