"""Along how much of its route a wire lies outside its ducts, by depth pictures from above."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from remodel_vision.board.new_points import new_points, without_noise
from remodel_work.camera import Picture, are_nearest
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Duct, Panel
from remodel_work.routes import step_in

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
