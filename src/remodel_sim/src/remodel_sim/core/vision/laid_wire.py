"""Where a wire runs past a place, by a colour and depth picture from above."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from remodel_sim.core.camera import Picture
from remodel_sim.core.geometry import Array, Pose
from remodel_sim.core.workpiece.panel import PanelWire

# Samples are so far apart across the wire [m], and as many, so far apart, are taken along it.
ACROSS_M = 0.00025
ALONG_M = np.linspace(-0.0015, 0.0015, 7)
# Below this likelihood of the wire's colour there is no wire.
MIN_LIKELIHOOD = 0.3
# To each side of where it is expected a wire is searched for around a circle [rad].
TURN_RAD = np.radians(60.0)
# The camera looks along the wire's height twice: once at the height that is expected.
LOOKS = 2


@dataclass(frozen=True)
class Passing:
    """How a wire passes a place.

    Attributes:
        aside: of its axis from the place's own, along its y [m].
        height: of its axis, world frame [m].
    """

    aside: float
    height: float


def wire_past(
    place: Pose,
    reach: float,
    picture: Picture,
    likelihood: npt.NDArray[np.float32],
    wire: PanelWire,
) -> Passing | None:
    """Return how a wire passes a place, or None where none is seen.

    Args:
        place: where its axis is expected, x along it, world frame.
        reach: how far to each side it is searched for [m].
        picture: from above, with depth.
        likelihood: of the wire's colour in the picture.
        wire: whose diameter and colour are searched for.
    """
    across = np.arange(-reach, reach + ACROSS_M, ACROSS_M)
    height, aside = float(place.position[2]), 0.0
    for _ in range(LOOKS):
        pixels = picture.view.project(_grid(place, across, height + wire.radius))
        seen = _sample(likelihood, pixels).reshape(len(across), len(ALONG_M)).mean(axis=1)
        span = _nearest_run(seen >= MIN_LIKELIHOOD, abs(across))
        if span is None:
            return None
        aside = float(np.average(across[span], weights=seen[span]))
        crest = _grid(place, np.array([aside]), height + wire.radius)
        height = _height(picture, crest) - wire.radius
    return Passing(aside, height)


def wire_around(
    centre: Array,
    radius: float,
    towards: float,
    picture: Picture,
    likelihood: npt.NDArray[np.float32],
    wire: PanelWire,
) -> float | None:
    """Return in which direction a wire crosses a circle on the plate, or None where none is seen.

    Args:
        centre: of the circle, (2,) [m], world frame.
        radius: of the circle [m].
        towards: direction in which it is searched for, up to TURN_RAD to each side [rad].
        picture: from above.
        likelihood: of the wire's colour in the picture.
        wire: whose diameter and colour are searched for.

    Returns:
        The angle from `towards` [rad].
    """
    turns = np.arange(-TURN_RAD, TURN_RAD, ACROSS_M / radius)
    turn, out = np.meshgrid(turns, radius + ALONG_M, indexing="ij")
    angle, away = towards + turn.ravel(), out.ravel()
    x, y = centre[0] + away * np.cos(angle), centre[1] + away * np.sin(angle)
    points = np.column_stack([x, y, np.full(x.size, wire.radius)])
    seen = _sample(likelihood, picture.view.project(points)).reshape(turn.shape).mean(axis=1)
    span = _nearest_run(seen >= MIN_LIKELIHOOD, abs(turns))
    return None if span is None else float(np.average(turns[span], weights=seen[span]))


def _grid(place: Pose, across: Array, height: float) -> Array:
    """Return points (n, 3) [m] across and along a place, at one height."""
    y, x = np.meshgrid(across, ALONG_M, indexing="ij")
    points = place.apply(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    points[:, 2] = height
    return points


def _sample(image: npt.NDArray[np.float32], pixels: Array) -> Array:
    u, v = pixels.astype(np.float32).T
    return np.asarray(cv2.remap(image, u, v, cv2.INTER_LINEAR), np.float64).ravel()


def _nearest_run(wanted: npt.NDArray[np.bool_], distance: Array) -> slice | None:
    """Return the run of true values that comes nearest to the middle."""
    edges = np.flatnonzero(np.diff(np.r_[0, wanted.astype(int), 0])).reshape(-1, 2)
    if not len(edges):
        return None
    first, last = min(edges, key=lambda run: float(distance[run[0] : run[1]].min()))
    return slice(int(first), int(last))


def _height(picture: Picture, points: Array) -> float:
    """Return the height that the depth camera sees around points (n, 3) [m], their median."""
    assert picture.depth is not None, "the overhead camera measures depth"
    pixels = picture.view.project(points)
    depths = _sample(picture.depth.astype(np.float32), pixels)
    return float(np.median(picture.view.at_depth(pixels, depths)[:, 2]))
