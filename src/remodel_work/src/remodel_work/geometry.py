"""Rigid poses. Quaternions are (x, y, z, w); a transform `a_from_b` maps b's coordinates to a's."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# Frames that goals are given in.
WORLD, PANEL = "world", "panel"


def wrap_angle(angle_rad: float) -> float:
    """Return the same direction in [-pi, pi)."""
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


def rotation_matrix(quaternion: Array) -> Array:
    """Return the (3, 3) rotation matrix of a unit quaternion."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def multiply_quaternions(left: Array, right: Array) -> Array:
    """Return the rotation `right` followed by `left`."""
    ax, ay, az, aw = left
    bx, by, bz, bw = right
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def turn_between(start: Array, end: Array) -> Array:
    """Return the quaternion (4,) of the shortest turn from one unit vector (3,) to another.

    They must not be opposite.
    """
    quaternion = np.append(np.cross(start, end), 1.0 + float(start @ end))
    return np.asarray(quaternion / np.linalg.norm(quaternion))


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid transform.

    Attributes:
        position: (3,) [m].
        quaternion: (4,) unit quaternion.
    """

    position: Array
    quaternion: Array

    @staticmethod
    def level(x: float, y: float, z: float, yaw_rad: float = 0.0) -> Pose:
        """Return an upright pose: its z axis is the parent's."""
        half = yaw_rad / 2
        return Pose(np.array([x, y, z]), np.array([0.0, 0.0, math.sin(half), math.cos(half)]))

    @property
    def rotation(self) -> Array:
        """The (3, 3) rotation matrix."""
        return rotation_matrix(self.quaternion)

    @property
    def yaw(self) -> float:
        """The direction of the x axis about the parent's z axis [rad]."""
        x_axis = self.rotation[:, 0]
        return math.atan2(x_axis[1], x_axis[0])

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: `a_from_b @ b_from_c` is `a_from_c`."""
        return Pose(
            self.apply(other.position), multiply_quaternions(self.quaternion, other.quaternion)
        )

    def inverse(self) -> Pose:
        """Return the transform the other way round."""
        conjugate = self.quaternion * np.array([-1.0, -1.0, -1.0, 1.0])
        return Pose(-(rotation_matrix(conjugate) @ self.position), conjugate)

    def apply(self, points: Array) -> Array:
        """Map points, (3,) or (n, 3) [m], into the parent's frame."""
        return points @ self.rotation.T + self.position
