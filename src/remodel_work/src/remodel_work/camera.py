"""Pinhole cameras. Optical frame: x right and y down in the picture, z along the view.

Pixel (u, v) is a column and a row; whole numbers are pixel centres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from remodel_work.geometry import Array, Pose

# Where PyBullet's TinyRenderer puts the optical axis, from the middle of the picture [px]; measured
# on a grid of rendered spheres (test_camera.py repeats it).
PRINCIPAL_OFFSET_PX = (0.5, -0.5)


@dataclass(frozen=True)
class Lens:
    """Intrinsics of a camera without distortion.

    Attributes:
        width, height: of the picture [px].
        field_of_view: vertical [rad].
    """

    width: int
    height: int
    field_of_view: float

    @property
    def focal_px(self) -> float:
        """Focal length [px], equal for both axes."""
        return self.height / 2 / math.tan(self.field_of_view / 2)

    @property
    def centre_px(self) -> Array:
        """The optical axis in the picture, (2,) [px]."""
        middle = np.array([self.width - 1, self.height - 1]) / 2
        return middle + PRINCIPAL_OFFSET_PX


@dataclass(frozen=True, eq=False)
class View:
    """A camera in its place at the moment of a picture."""

    lens: Lens
    world_from_camera: Pose

    def project(self, points: Array) -> Array:
        """Map world points (n, 3) [m] to pixels (n, 2)."""
        local = self.world_from_camera.inverse().apply(np.atleast_2d(points))
        return local[:, :2] / local[:, 2:] * self.lens.focal_px + self.lens.centre_px

    def on_plane(self, pixels: Array, z: float | Array) -> Array:
        """Map pixels (n, 2) to the world points (n, 3) [m] at height z [m]."""
        pixels = np.atleast_2d(pixels)
        flat = (pixels - self.lens.centre_px) / self.lens.focal_px
        rays = np.column_stack([flat, np.ones(len(flat))]) @ self.world_from_camera.rotation.T
        eye = self.world_from_camera.position
        return eye + rays * ((z - eye[2]) / rays[:, 2])[:, None]

    def at_depth(self, pixels: Array, depths: Array) -> Array:
        """Map pixels (n, 2) with depths (n,) along the axis [m] to world points (n, 3) [m]."""
        flat = (np.atleast_2d(pixels) - self.lens.centre_px) / self.lens.focal_px
        local = np.column_stack([flat, np.ones(len(flat))]) * np.asarray(depths)[:, None]
        return self.world_from_camera.apply(local)

    def sees(self, points: Array, margin_px: float) -> bool:
        """Return whether all points (n, 3) [m] lie inside the picture by a margin."""
        pixels = self.project(points)
        limit = np.array([self.lens.width, self.lens.height]) - 1 - margin_px
        return bool(np.all(pixels >= margin_px) and np.all(pixels <= limit))

    def margin_px(self, points: Array) -> float:
        """Return how far inside the picture all points (n, 3) [m] lie; negative: one does not."""
        pixels = self.project(points)
        limit = np.array([self.lens.width, self.lens.height]) - 1
        return float(np.minimum(pixels, limit - pixels).min())

    def is_at(self, other: View) -> bool:
        """Return whether a camera stands where another one does."""
        here, there = (view.world_from_camera.position for view in (self, other))
        return bool(np.allclose(here, there, atol=1e-6))

    def metres_per_pixel(self, z: float) -> float:
        """Return the size of a pixel at height z, seen from above."""
        return (self.world_from_camera.position[2] - z) / self.lens.focal_px


@dataclass(frozen=True, eq=False)
class Picture:
    """What a camera saw.

    Attributes:
        rgb: (height, width, 3) uint8.
        depth: (height, width) along the optical axis [m]; None of a camera without depth.
        view: where it was taken from.
    """

    rgb: npt.NDArray[np.uint8]
    depth: Array | None
    view: View

    @cached_property
    def single_depth(self) -> npt.NDArray[np.float32]:
        """The depth in single precision, as OpenCV samples it [m]."""
        assert self.depth is not None, "the camera measures depth"
        return self.depth.astype(np.float32)


def overhead_name(number: int) -> str:
    """Return the name of a camera above the plate, from 0: overhead, overhead_2, ..."""
    return "overhead" if number == 0 else f"overhead_{number + 1}"


def best_view(views: Sequence[View], points: Array) -> int:
    """Return the number of the view whose picture shows all points (n, 3) [m] best.

    It is the one in which the point nearest to the picture's edge is farthest inside.
    """
    return max(range(len(views)), key=lambda i: views[i].margin_px(points))


def are_nearest(points: Array, views: Sequence[View], number: int) -> npt.NDArray[np.bool_]:
    """Return which points (n, 3) [m] lie nearer to a camera's axis than to any other one's, (n,).

    So several cameras that look straight down divide a plate between them.
    """
    if len(views) == 1:
        return np.ones(len(points), bool)
    axes = np.array([view.world_from_camera.position[:2] for view in views])
    away = np.linalg.norm(points[:, None, :2] - axes, axis=2)
    return np.asarray(away.argmin(axis=1) == number)


def looking_down(x: float, y: float, z: float, up_yaw: float) -> Pose:
    """Return the optical frame of a camera that looks straight down.

    Args:
        x: of the lens [m], world frame.
        y: the same.
        z: the same.
        up_yaw: world direction that is up in the picture [rad].
    """
    right, down, forward = (
        np.array([math.sin(up_yaw), -math.cos(up_yaw), 0.0]),
        np.array([-math.cos(up_yaw), -math.sin(up_yaw), 0.0]),
        np.array([0.0, 0.0, -1.0]),
    )
    return Pose(np.array([x, y, z]), _quaternion(np.column_stack([right, down, forward])))


def looking_at(eye: Array, target: Array) -> Pose:
    """Return the optical frame of a level camera at `eye` directed at `target`, (3,) [m]."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return Pose(eye, _quaternion(np.column_stack([right, np.cross(forward, right), forward])))


def _quaternion(rotation: Array) -> Array:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix (3, 3)."""
    # Bar-Itzhack (2000): the eigenvector of the largest eigenvalue; no special cases.
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    k = np.array(
        [
            [xx - yy - zz, xy + yx, xz + zx, zy - yz],
            [xy + yx, yy - xx - zz, yz + zy, xz - zx],
            [xz + zx, yz + zy, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    return np.linalg.eigh(k)[1][:, -1]
