"""How much of a wire was laid beside the ducts of a plate, by depth pictures from above."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from remodel_sim.core.camera import Picture
from remodel_sim.core.geometry import Array
from remodel_sim.core.workpiece.layout import WORLD_FROM_PANEL
from remodel_sim.core.workpiece.panel import Duct, Panel

# A wire that lies on a duct's wall, or stands over it, is so near to it [m].
BESIDE_DUCT_M = 0.020
# What is higher is a hand, or is held by one [m].
HELD_M = 0.10
# So near to where a wire goes on outside its ducts it may be, seen from above [m].
BESIDE_WAY_M = 0.060
# What stood somewhere before is found again so near to its place [pixels].
AGAIN_PX = 2
# What is narrower than this is the depth camera's noise.
LEAST_PX = np.ones((2, 2), np.uint8)


def length_beside_ducts(
    picture: Picture, before: Picture, panel: Panel, radius: float, ways: Sequence[Array]
) -> float:
    """Return how much of a wire lies on the plate beside its ducts [m].

    Args:
        picture: with depth, from above, the wire in it.
        before: the same, before the wire was laid.
        panel: whose plate they show.
        radius: of the wire [m].
        ways: lines (2, 3) along which the wire may be outside the ducts, world frame [m].
    """
    points, stood = _points_of(picture), _points_of(before, AGAIN_PX)
    is_own = (points[:, 2] > stood[:, 2] + radius) & (points[:, 2] < HELD_M)
    is_own &= _are_on_plate(points, panel) & ~_are_near_ducts(points, panel.ducts)
    for way in ways:
        is_own &= _distances(points, way) > BESIDE_WAY_M
    assert picture.depth is not None, "its points"
    mask = is_own.reshape(picture.depth.shape).astype(np.uint8)
    is_own = cv2.morphologyEx(mask, cv2.MORPH_OPEN, LEAST_PX).ravel() > 0
    if not is_own.any():
        return 0.0
    pixel = picture.view.metres_per_pixel(float(points[is_own, 2].mean()))
    return float(is_own.sum() * pixel**2 / (2 * radius))


def _points_of(picture: Picture, around: int = 0) -> Array:
    """Return what a depth camera sees as points (n, 3) [m], world frame, row by row.

    For each pixel it is the nearest to the camera of so many pixels around it.
    """
    assert picture.depth is not None, "the camera measures depth"
    near = np.ones(2 * [2 * around + 1])
    depth = np.asarray(cv2.erode(picture.depth.astype(np.float32), near), np.float64)
    rows, columns = np.indices(depth.shape).reshape(2, -1)
    return picture.view.at_depth(np.column_stack([columns, rows]).astype(np.float64), depth.ravel())


def _are_on_plate(points: Array, panel: Panel) -> npt.NDArray[np.bool_]:
    at = np.abs(WORLD_FROM_PANEL.inverse().apply(points)[:, :2])
    return np.asarray((at <= np.array(panel.size[:2]) / 2).all(axis=1))


def _are_near_ducts(points: Array, ducts: Sequence[Duct]) -> npt.NDArray[np.bool_]:
    """Return which points (n, 3) are in a duct, or beside one."""
    near = np.zeros(len(points), bool)
    for duct in ducts:
        at = np.abs((WORLD_FROM_PANEL @ duct.panel_from_duct).inverse().apply(points)[:, :2])
        near |= (at <= np.array([duct.length, duct.width]) / 2 + BESIDE_DUCT_M).all(axis=1)
    return near


def _distances(points: Array, line: Array) -> Array:
    """Return how far points (n, 3) are from a line (2, 3), seen from above (n,) [m]."""
    start, way = line[0, :2], (line[1] - line[0])[:2]
    share = np.clip((points[:, :2] - start) @ way / max(float(way @ way), 1e-9), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points[:, :2] - start - share[:, None] * way, axis=1))
