"""What a depth picture from above shows of a wire that was not there before."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from remodel_work.camera import Picture, are_nearest
from remodel_work.geometry import Array
from remodel_work.panel import Panel

# What is higher is a hand [m]: a wire that sprang out of its ducts stood 235 mm high.
HAND_M = 0.30
# What is nearer to the middle of a hand, seen from above, may be that hand [m].
NEAR_HAND_M = 0.15
# What stood somewhere before is found again so near to its place [pixels].
AGAIN_PX = 2
# What is narrower than this is the depth camera's noise.
LEAST_PX = np.ones((2, 2), np.uint8)


def new_points(
    picture: Picture, before: Picture, radius: float
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return what a picture shows as points (n, 3) [m], and which are a wire's of a radius.

    Args:
        picture: with depth, from above, the wire in it.
        before: the same, without the wire.
        radius: of the wire [m].
    """
    points, stood = _points_of(picture), _points_of(before, AGAIN_PX)
    return points, (points[:, 2] > stood[:, 2] + radius) & (points[:, 2] < HAND_M)


def new_length(
    pairs: Sequence[tuple[Picture, Picture]], panel: Panel, radius: float, hands: Sequence[Array]
) -> float:
    """Return along how much a new wire is seen on the panel [m].

    Args:
        pairs: of pictures with depth, from above, each by another camera: one now, and one
            without the wire.
        panel: whose plate they show.
        radius: of the wire [m].
        hands: of the robots (3,) [m], world frame; what is near one is not counted.
    """
    views, length = [picture.view for picture, _ in pairs], 0.0
    for number, (picture, before) in enumerate(pairs):
        points, is_new = new_points(picture, before, radius)
        at = np.abs(panel.world_from_panel.inverse().apply(points)[:, :2])
        is_new &= (at <= np.array(panel.size[:2]) / 2).all(axis=1)
        is_new &= are_nearest(points, views, number)
        for hand in hands:
            is_new &= np.linalg.norm((points - hand)[:, :2], axis=1) > NEAR_HAND_M
        seen = points[without_noise(picture, is_new)]
        if len(seen):
            pixel = picture.view.metres_per_pixel(float(seen[:, 2].mean()))
            length += len(seen) * pixel**2 / (2 * radius)
    return length


def without_noise(picture: Picture, is_own: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return which of a wire's points in a picture are more than the depth camera's noise."""
    assert picture.depth is not None, "its points"
    mask = is_own.reshape(picture.depth.shape).astype(np.uint8)
    return cv2.morphologyEx(mask, cv2.MORPH_OPEN, LEAST_PX).ravel() > 0


def _points_of(picture: Picture, around: int = 0) -> Array:
    """Return what a depth camera sees as points (n, 3) [m], world frame, row by row.

    For each pixel it is the nearest to the camera of so many pixels around it.
    """
    near = np.ones(2 * [2 * around + 1])
    depth = np.asarray(cv2.erode(picture.single_depth, near), np.float64)
    rows, columns = np.indices(depth.shape).reshape(2, -1)
    return picture.view.at_depth(np.column_stack([columns, rows]).astype(np.float64), depth.ravel())
