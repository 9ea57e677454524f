"""What stands on a plate and is not drawn, by a depth picture from above: wires."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from remodel_states.core.wires.wire_colours import WIRE_RGB
from remodel_work.camera import Picture
from remodel_work.component_shape import Box
from remodel_work.geometry import Array
from remodel_work.obstacles import WIRES, Obstacles, Solid
from remodel_work.panel import Panel

# The plate is divided into squares of this side [m].
CELL_M = 0.008
# What is drawn may be so far from where it is, aside and in height [m].
ASIDE_M = 0.006
RISE_M = 0.006
# What is higher is no wire, but a robot [m].
MOST_M = 0.20
# Wires also stand out beyond the plate, so far [m].
OUTSIDE_M = 0.03
# Every so many pixels is looked at, across and down.
EVERY_PX = 2
# So many of a square's points are lower than its height: one wire covers a fifth of it [%].
TOP_PERCENT = 90.0


def standing_wires(pictures: Sequence[Picture], panel: Panel, drawn: Obstacles) -> Obstacles:
    """Return columns up to what stands higher than what is drawn; all are named WIRES.

    Wires below the rims of their ducts are none: only a hand that lays wires comes there.

    Args:
        pictures: with depth, from above, each by another camera; without, nothing is seen.
        panel: whose plate they show.
        drawn: what is known to stand there, world frame.
    """
    if any(picture.depth is None for picture in pictures):
        return Obstacles()
    shape = np.ceil((np.array(panel.size[:2]) + 2 * OUTSIDE_M) / CELL_M).astype(int)
    corner = panel.world_from_panel.position[:2] - shape * CELL_M / 2
    known = _drawn_heights(panel, drawn, corner, (int(shape[0]), int(shape[1])))
    tops = np.max([_seen_heights(picture, corner, known.shape) for picture in pictures], axis=0)
    stands = (tops > known + RISE_M) & (tops < MOST_M)
    columns = []
    for i, j in zip(*np.nonzero(stands), strict=True):
        x, y = (float(v) for v in corner + (np.array([i, j]) + 0.5) * CELL_M)
        bottom, top = float(known[i, j]), float(tops[i, j])
        box = Box((x, y, (bottom + top) / 2), (CELL_M, CELL_M, top - bottom), WIRE_RGB["BK"])
        columns.append(Solid(WIRES, box))
    return Obstacles(tuple(columns))


def _drawn_heights(panel: Panel, drawn: Obstacles, corner: Array, shape: tuple[int, int]) -> Array:
    """Return up to where each square is known to be taken [m], ducts up to their rims."""
    heights = np.zeros(shape)
    for low, high, top in _footprints(panel, drawn):
        first = np.floor((low - ASIDE_M - corner) / CELL_M).astype(int)
        last = np.ceil((high + ASIDE_M - corner) / CELL_M).astype(int)
        (i, j), (k, m) = np.maximum(first, 0), np.maximum(last, 0)
        heights[i:k, j:m] = np.maximum(heights[i:k, j:m], top)
    return heights


def _footprints(panel: Panel, drawn: Obstacles) -> Iterator[tuple[Array, Array, float]]:
    """Yield the level bounds (2,) and (2,) and the top of what is drawn [m], world frame."""
    for solid in drawn.solids:
        centre, half = np.array(solid.box.centre), np.array(solid.box.size) / 2
        yield _bounds(centre, half, solid.box.rpy[2], float(centre[2] + half[2]))
    for duct in panel.ducts:
        place = panel.world_from_panel @ duct.panel_from_duct
        half = np.array([duct.length, duct.width, 0.0]) / 2
        yield _bounds(place.position, half, place.yaw, duct.height)


def _bounds(centre: Array, half: Array, yaw: float, top: float) -> tuple[Array, Array, float]:
    turned = np.array([[np.cos(yaw), np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    reach = np.abs(turned) @ half[:2]
    return centre[:2] - reach, centre[:2] + reach, top


def _seen_heights(picture: Picture, corner: Array, shape: tuple[int, ...]) -> Array:
    """Return the height of each square as the camera sees it [m]; 0 where it sees nothing."""
    assert picture.depth is not None, "the caller's check"
    depths = picture.depth[::EVERY_PX, ::EVERY_PX]
    rows, columns = EVERY_PX * np.indices(depths.shape).reshape(2, -1)
    points = picture.view.at_depth(np.column_stack([columns, rows]), depths.ravel())
    cells = np.floor((points[:, :2] - corner) / CELL_M).astype(int)
    inside = np.all((cells >= 0) & (cells < shape), axis=1)
    squares = np.ravel_multi_index(tuple(cells[inside].T), shape)
    z = points[inside, 2]
    order = np.lexsort((z, squares))
    found, first, counts = np.unique(squares[order], return_index=True, return_counts=True)
    heights = np.zeros(shape)
    heights.flat[found] = z[order][first + (counts - 1) * int(TOP_PERCENT) // 100]
    return heights
