"""What depth pictures from above show of wires on a board: new, standing, outside, graspable."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.cell import footprint
from remodel_states.core.wires import WIRE_RGB
from remodel_work.camera import Picture, are_nearest
from remodel_work.component_shape import Box
from remodel_work.geometry import Array, Pose
from remodel_work.obstacles import WIRES, Obstacles, Solid
from remodel_work.panel import Duct, Panel
from remodel_work.routes import step_in

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
        is_new &= _are_over(points, panel.world_from_panel, panel.size)
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
    (x, y, _), yaw = panel.world_from_panel.position, panel.world_from_panel.yaw
    low, high = np.array(footprint((float(x), float(y)), panel.size[:2], yaw))
    shape = np.ceil((high - low + 2 * OUTSIDE_M) / CELL_M).astype(int)
    corner = (low + high) / 2 - shape * CELL_M / 2
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


# A wire that hangs out of its duct is so near to it [m]; what is farther lies elsewhere.
OUTSIDE_DUCT_M = 0.040
# So near to where a wire goes on to its terminals it may be outside its ducts, seen from above [m].
BESIDE_WAY_M = 0.030
# It is outside along the whole step to a place when more than this share of it is seen outside, and
# no more than that share in its ducts: otherwise it only curls up beside the place.
LEAST_OUTSIDE = 0.25
LEAST_INSIDE = 0.75


def route_outside_ducts(
    pairs: Sequence[tuple[Picture, Picture]],
    panel: Panel,
    places: Mapping[Duct, Sequence[Pose]],
    radius: float,
    ways: Sequence[Array],
) -> float:
    """Return along how much of its route in ducts a wire lies over their rims, or beside them [m].

    The length that is seen elsewhere on the panel counts, too.

    Args:
        pairs: of pictures with depth, from above, each by another camera: one of the wire, fixed
            at both ends, and one before it was laid.
        panel: on which the ducts are.
        places: of its route in each duct, `step_in` it apart, world frame.
        radius: of the wire [m].
        ways: lines (2, 3) along which it goes from its ducts to its terminals, world frame [m].
    """
    views = [picture.view for picture, _ in pairs]
    at = np.array([place.position[:2] for duct in places for place in places[duct]])
    steps = np.array([step_in(duct) for duct in places for _ in places[duct]])
    outside, inside, elsewhere = np.zeros((3, len(at)))
    for number, (picture, before) in enumerate(pairs):
        points, is_own = new_points(picture, before, radius)
        is_own &= are_nearest(points, views, number)
        shares = _shares(picture, points, is_own, panel, places, ways)
        for length, seen in zip((outside, inside, elsewhere), shares, strict=True):
            length += _lengths(picture, seen, at, radius)
    is_out = (outside > LEAST_OUTSIDE * steps) & (inside <= LEAST_INSIDE * steps)
    return float(steps[is_out].sum() + elsewhere.sum())


def _shares(
    picture: Picture,
    points: Array,
    is_own: npt.NDArray[np.bool_],
    panel: Panel,
    places: Mapping[Duct, Sequence[Pose]],
    ways: Sequence[Array],
) -> tuple[Array, Array, Array]:
    """Return a wire's points beside or over the ducts, in them, and elsewhere, (n, 3) [m] each."""
    own = points[is_own]
    is_inside = np.zeros(len(own), bool)
    for duct in places:
        is_inside |= _are_near(own, panel, [duct], 0.0) & (own[:, 2] < duct.height)
    is_outside = ~is_inside
    for way in ways:
        is_outside &= _distances(own, way) > BESIDE_WAY_M
    is_beside = _are_near(own, panel, places, OUTSIDE_DUCT_M)
    is_elsewhere = is_outside & ~is_beside & _are_over(own, panel.world_from_panel, panel.size)

    def seen(which: npt.NDArray[np.bool_]) -> Array:
        """Return those of the wire's points without the noise."""
        shown = np.zeros(len(points), bool)
        shown[is_own] = which
        return points[without_noise(picture, shown)]

    return seen(is_outside & is_beside), seen(is_inside), seen(is_elsewhere)


def _lengths(picture: Picture, seen: Array, at: Array, radius: float) -> Array:
    """Return how much of a wire's points (n, 3) is nearest to each of the places (m, 2); (m,) [m].

    They are as many as a wire of a radius covers along that length.
    """
    if not len(seen):
        return np.zeros(len(at))
    nearest = np.linalg.norm(seen[:, None, :2] - at, axis=2).argmin(axis=1)
    pixel = picture.view.metres_per_pixel(float(seen[:, 2].mean()))
    return np.asarray(np.bincount(nearest, minlength=len(at)) * pixel**2 / (2 * radius))


def _are_near(
    points: Array, panel: Panel, ducts: Iterable[Duct], beside: float
) -> npt.NDArray[np.bool_]:
    """Return which points (n, 3), seen from above, are in a duct, or so far beside one [m]."""
    near = np.zeros(len(points), bool)
    for duct in ducts:
        size = (duct.length + 2 * beside, duct.width + 2 * beside)
        near |= _are_over(points, panel.world_from_panel @ duct.panel_from_duct, size)
    return near


def _are_over(points: Array, frame: Pose, size: Sequence[float]) -> npt.NDArray[np.bool_]:
    """Return which points (n, 3), seen from above, are within a size around a frame [m]."""
    at = np.abs(frame.inverse().apply(points)[:, :2])
    return np.asarray((at <= np.array(size[:2]) / 2).all(axis=1))


def _distances(points: Array, line: Array) -> Array:
    """Return how far points (n, 3) are from a line (2, 3), seen from above (n,) [m]."""
    start, way = line[0, :2], (line[1] - line[0])[:2]
    share = np.clip((points[:, :2] - start) @ way / max(float(way @ way), 1e-9), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points[:, :2] - start - share[:, None] * way, axis=1))


# Around a place, so much of a wire to each side shows how it runs there [m].
AROUND_M = 0.020
# It is graspable where it is seen from above along so much of that, and is straight: it lies no
# farther aside than so much of its length.
LEAST_SEEN = 0.75
MOST_ASIDE = 0.2
# Places are so far apart [m].
APART_M = 0.030
# Its crest is that of so much of it to each side [m]; so much of what is seen of it lies below the
# crest, but for the depth camera's noise [%].
CREST_M = 0.004
CREST_PERCENT = 95.0


def graspable_places(picture: Picture, before: Picture, radius: float) -> Iterator[Pose]:
    """Yield where a new wire runs straight and nearly level, the highest place first.

    Args:
        picture: with depth, from above, the wire in it.
        before: the same, without the wire.
        radius: of the wire [m].

    Yields:
        A place on its axis, x along it, world frame.
    """
    points, is_own = new_points(picture, before, radius)
    seen = points[without_noise(picture, is_own)]
    left = seen
    while len(left):
        top = left[left[:, 2].argmax()]
        left = left[np.linalg.norm(left[:, :2] - top[:2], axis=1) > APART_M]
        place = _place_at(seen[np.linalg.norm(seen - top, axis=1) < AROUND_M], radius)
        if place is not None:
            yield place


def _place_at(points: Array, radius: float) -> Pose | None:
    """Return how a wire runs through points on it (n, 3); None where it is not graspable."""
    middle = points.mean(axis=0)
    away = points[:, :2] - middle[:2]
    lengths, ways = np.linalg.eigh(away.T @ away)
    along, aside = away @ ways[:, 1], lengths[0]
    if np.ptp(along) < LEAST_SEEN * 2 * AROUND_M or aside > MOST_ASIDE**2 * lengths[1]:
        return None
    crest = points[np.abs(along) < CREST_M, 2]
    if not len(crest):
        return None
    x, y = (float(v) for v in middle[:2])
    z = float(np.percentile(crest, CREST_PERCENT)) - radius
    return Pose.level(x, y, z, math.atan2(ways[1, 1], ways[0, 1]))
