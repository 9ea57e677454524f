"""Where a panel lies, by the depth camera: its plate, rails, ducts and devices as one relief.

The design says how high the panel is at each of its places. The points that the camera sees are
laid into this relief at poses of the panel on the plate's plane, coarse ones first; the pose at
which their heights fit best is taken. What is not in the design, such as an arm or a wire, counts
no more than any other point that does not fit. Light and colours have no influence.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
import numpy.typing as npt

from remodel_work.camera import Picture
from remodel_work.geometry import Array, Pose
from remodel_work.obstacles import panel_obstacles
from remodel_work.panel import Panel

# A sample of the relief, and how much of its surroundings it covers [m].
CELL_M, AROUND_M = 0.001, 0.03
# A height differs by no more than this from the relief's [m]; more counts as much.
FAR_M = 0.006
# What is so much higher than all of the panel is an arm or a wire in the air [m].
ABOVE_M = 0.010
# So much of the panel is seen past them. Of what is higher than the plate by this [m], as drawn or
# as seen, so much is both: that of another panel is not.
LEAST_SEEN, HIGH_M, LEAST_FITTING = 0.4, 0.005, 0.45


@dataclass(frozen=True)
class Step:
    """A search around the best pose so far.

    Attributes:
        reach, step: along x and y [m].
        reach_rad, step_rad: about z.
        every: one of so many pixels of the picture takes part, along each axis.
        blur: of the relief [m].
    """

    reach: float
    step: float
    reach_rad: float
    step_rad: float
    every: int
    blur: float


SEARCH = (
    Step(0.012, 0.004, math.radians(3.0), math.radians(0.5), 10, 0.004),
    Step(0.003, 0.001, math.radians(0.4), math.radians(0.1), 6, 0.001),
    Step(0.00075, 0.00025, math.radians(0.08), math.radians(0.02), 4, 0.0),
)


def register_panel(picture: Picture, panel: Panel) -> Pose | None:
    """Return the panel's frame in the world; None when what is seen is not this panel.

    Args:
        picture: with depth, from above.
        panel: as drawn; it lies within 12 mm and 3 degrees of its place in the cell.
    """
    relief = _relief(panel)
    points = _points(picture, panel)
    on_panel = np.isfinite(points[..., 2])
    points[points[..., 2] > relief.max() + ABOVE_M] = np.nan
    if np.isfinite(points[..., 2]).sum() < LEAST_SEEN * on_panel.sum():
        return None
    best = np.zeros(3)
    for step in SEARCH:
        sigma = step.blur / CELL_M
        shown = np.asarray(cv2.GaussianBlur(relief, (0, 0), sigma), np.float32) if sigma else relief
        sparse = points[:: step.every, :: step.every].reshape(-1, 3)
        sparse = sparse[np.isfinite(sparse[:, 2])]
        centre = best
        found = min((_cost(shown, sparse, pose), pose) for pose in _around(centre, step))
        best = np.array(found[1])
        if step is SEARCH[0] and np.any(np.abs(best) > [*[step.reach * 0.99] * 2, 0.051]):
            return None
    drawn, seen = _heights(relief, sparse, (best[0], best[1], best[2]))
    high = (drawn > HIGH_M) | (seen > HIGH_M)
    if high.any() and np.mean(np.abs(drawn - seen)[high] < FAR_M) < LEAST_FITTING:
        return None
    return panel.world_from_panel @ Pose.level(best[0], best[1], 0.0, best[2])


def _around(centre: Array, step: Step) -> Iterator[tuple[float, float, float]]:
    along = np.arange(-step.reach, step.reach + step.step / 2, step.step)
    about = np.arange(-step.reach_rad, step.reach_rad + step.step_rad / 2, step.step_rad)
    for dx, dy, turn in product(along, along, about):
        yield float(centre[0] + dx), float(centre[1] + dy), float(centre[2] + turn)


def _cost(
    relief: npt.NDArray[np.float32], points: Array, pose: tuple[float, float, float]
) -> float:
    """Return how far points (n, 3) [m], in the panel's drawn frame, are from a relief at a pose."""
    drawn, seen = _heights(relief, points, pose)
    return float(np.mean(np.minimum(np.abs(drawn - seen), FAR_M)))


def _heights(
    relief: npt.NDArray[np.float32], points: Array, pose: tuple[float, float, float]
) -> tuple[Array, Array]:
    """Return the heights of a relief at a pose where points lie on it, and those of the points."""
    x, y, turn = pose
    c, s = math.cos(turn), math.sin(turn)
    dx, dy = points[:, 0] - x, points[:, 1] - y
    rows = ((c * dx + s * dy) / CELL_M + relief.shape[0] / 2).astype(np.intp)
    columns = ((c * dy - s * dx) / CELL_M + relief.shape[1] / 2).astype(np.intp)
    inside = (rows >= 0) & (rows < relief.shape[0]) & (columns >= 0) & (columns < relief.shape[1])
    return relief[rows[inside], columns[inside]].astype(np.float64), points[inside, 2]


def _points(picture: Picture, panel: Panel) -> Array:
    """Return what a picture shows in the panel's drawn frame, (height, width, 3) [m].

    What is not on the panel, or right beside it, is NaN.
    """
    assert picture.depth is not None, "the camera from above measures depth"
    height, width = picture.depth.shape
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    pixels = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
    points = picture.view.at_depth(pixels, picture.depth.ravel())
    points = panel.world_from_panel.inverse().apply(points)
    reach = np.array(panel.size[:2]) / 2 + AROUND_M / 2
    points[np.any(np.abs(points[:, :2]) > reach, axis=1)] = np.nan
    return points.reshape(height, width, 3)


def _relief(panel: Panel) -> npt.NDArray[np.float32]:
    """Return the heights of a panel as drawn, one for each cell, x down and y to the right [m]."""
    size = np.ceil((np.array(panel.size[:2]) + 2 * AROUND_M) / CELL_M).astype(int)
    heights = np.full(tuple(size.tolist()), -panel.size[2], np.float32)
    low = np.rint((size - np.array(panel.size[:2]) / CELL_M) / 2).astype(int)
    heights[low[0] : size[0] - low[0], low[1] : size[1] - low[1]] = 0.0
    boxes = [solid.box for solid in panel_obstacles(panel, {}).solids]
    for box in sorted(boxes, key=lambda b: b.centre[2] + b.size[2] / 2):
        half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * box.size[:2] / 2
        corners = np.column_stack([half, np.zeros(4)])
        x, y, _ = box.centre
        placed = panel.world_from_panel.inverse() @ Pose.level(x, y, 0.0, box.rpy[2])
        cells = placed.apply(corners)[:, :2] / CELL_M + size / 2 - 0.5
        top = box.centre[2] + box.size[2] / 2
        cv2.fillConvexPoly(heights, np.rint(cells[:, ::-1]).astype(np.int32), (top,))
    return heights
