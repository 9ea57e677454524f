"""Cables as values: curves through pixels, robust statistics, drawing."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from remodel_vision.colour import Pixels
from remodel_work.geometry import Array


def limited(values: npt.NDArray[Any], low: npt.ArrayLike, high: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return values, none of them below one limit or above another."""
    return np.minimum(np.maximum(values, low), high)


def median(values: npt.NDArray[Any]) -> float:
    """Return the upper median of a non-empty array, however shaped."""
    flat = values.ravel()
    return float(np.partition(flat, len(flat) // 2)[len(flat) // 2])


def median_colour(colours: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the upper median of each column of a non-empty array (n, k)."""
    return np.partition(colours, len(colours) // 2, axis=0)[len(colours) // 2]


def arc_lengths(points: Array) -> Array:
    """Return each point's distance from the first along a polyline (n,)."""
    arc = np.zeros(len(points))
    np.cumsum(np.abs(np.diff(_plane(points))), out=arc[1:])
    return arc


def _plane(points: Array) -> npt.NDArray[np.complex128]:
    """Return points (n, 2) as complex numbers (n,), which numpy works on in one go."""
    return np.ascontiguousarray(points).view(np.complex128)[:, 0]


def _points(plane: npt.NDArray[np.complex128]) -> Array:
    return plane.view(np.float64).reshape(-1, 2)


@lru_cache(maxsize=1024)
def parabola(count: int, degree: int) -> Array:
    """Return the matrix (degree + 1, count) of the polynomial through even steps from 0 to 1.

    Times values at the steps, it is the coefficients of the nearest polynomial, constant first.
    """
    powers = np.vander(np.linspace(0, 1, count), degree + 1, increasing=True)
    return np.linalg.solve(powers.T @ powers, powers.T)


def resample(points: Array, step: float) -> Array:
    """Return a polyline's points in even steps of about the given length, both ends kept."""
    arc = arc_lengths(points)
    count = max(4, round(arc[-1] / step) + 1)
    even = np.arange(count) * (arc[-1] / (count - 1))
    return _points(np.interp(even, arc, _plane(points)))


def smooth(points: Array, sigma: float) -> Array:
    """Return a polyline smoothed by a Gaussian of `sigma` points; its ends stay."""
    reach = min(max(1, int(2.5 * sigma)), len(points) - 1)
    plane = _plane(points)
    before = 2 * plane[0] - plane[reach:0:-1]
    after = 2 * plane[-1] - plane[-2 : -reach - 2 : -1]
    return _points(
        np.convolve(np.concatenate([before, plane, after]), _bell(reach, sigma), "valid")
    )


def _bell(reach: int, sigma: float) -> Array:
    """Return a Gaussian (2 reach + 1,) whose sum is 1."""
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    return np.asarray(kernel / kernel.sum())


def normals(points: Array) -> Array:
    """Return the unit normals (n, 2) of a polyline: its tangents turned from x towards y."""
    plane = _plane(points)
    tangent = np.empty_like(plane)
    tangent[1:-1] = plane[2:] - plane[:-2]
    tangent[0], tangent[-1] = plane[1] - plane[0], plane[-1] - plane[-2]
    return _points(1j * tangent / np.maximum(np.abs(tangent), 1e-9))


def across_gap(start: Array, heading: Array, end: Array, arriving: Array, step: float) -> Array:
    """Return the inner points of the cubic from one point to another.

    Args:
        start: (2,).
        heading: (2,) unit vector at the start.
        end: (2,).
        arriving: (2,) unit vector at the end.
        step: between points.
    """
    length = float(np.hypot(*(end - start)))
    count = int(length / step)
    if count < 1:
        return np.empty((0, 2))
    u = (np.arange(1, count + 1) / (count + 1))[:, None]
    return (
        (2 * u**3 - 3 * u**2 + 1) * start
        + (u**3 - 2 * u**2 + u) * length * heading
        + (3 * u**2 - 2 * u**3) * end
        + (u**3 - u**2) * length * arriving
    )


def at_distance(points: Array, distance: float) -> tuple[Array, Array]:
    """Return the point (k,) and the unit tangent (k,) at an arc length along a polyline (n, k).

    Beyond its end the polyline goes on straight.
    """
    pieces = np.linalg.norm(np.diff(points, axis=0), axis=1)
    i = int(np.clip(np.searchsorted(np.cumsum(pieces), distance), 0, len(pieces) - 1))
    tangent = (points[i + 1] - points[i]) / pieces[i]
    return points[i] + tangent * (distance - float(pieces[:i].sum())), tangent


DEGREE = 3
# Keeps parts without points smooth: the weight of second differences of neighbouring coefficients.
STIFFNESS = 1e-3


@dataclass(frozen=True, eq=False)
class Spline:
    """A plane B-spline in the form of FITPACK: knots, coefficients and degree.

    Attributes:
        t: (n + k + 1,) knots from 0 to 1, the first and last k + 1 equal.
        c_x: (n,) coefficients of the columns [px].
        c_y: (n,) coefficients of the rows [px].
        k: degree.
    """

    t: Array
    c_x: Array
    c_y: Array
    k: int = DEGREE

    def at(self, u: Array) -> Array:
        """Return the points (m, 2) [px] at parameters (m,) from 0 to 1."""
        return basis(self.t, u) @ np.column_stack([self.c_x, self.c_y])


def basis(t: Array, u: Array) -> Array:
    """Return the values (m, n) of the B-splines on knots t at u (m,), by Cox and de Boor."""
    last = len(t) - DEGREE - 2
    span = limited(np.searchsorted(t, u, side="right") - 1, DEGREE, last)
    values = np.ones((len(u), 1))
    for degree in range(1, DEGREE + 1):
        offsets = span[:, None] + np.arange(1, degree + 1)
        right = t[offsets]
        left = t[offsets - degree]
        share = values / (right - left)
        low = (right - u[:, None]) * share
        high = (u[:, None] - left) * share
        values = np.zeros((len(u), degree + 1))
        values[:, :-1] += low
        values[:, 1:] += high
    full = np.zeros((len(u), len(t) - DEGREE - 1))
    full[np.arange(len(u))[:, None], span[:, None] - DEGREE + np.arange(DEGREE + 1)] = values
    return full


def fit(points: Array, weights: Array, spacing: float) -> Spline:
    """Return the spline nearest to points (m, 2) with weights (m,), knots `spacing` apart [px]."""
    arc = arc_lengths(points)
    u = arc / arc[-1]
    pieces = max(1, round(arc[-1] / spacing))
    inner = np.arange(1, pieces) / pieces
    t = np.concatenate([np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)])
    rows = basis(t, u)
    weighted = rows * weights[:, None]
    density = max(float(weights.sum()), 1.0) / rows.shape[1]
    normal = weighted.T @ rows + density * _stiffness(rows.shape[1])
    c = np.linalg.solve(normal, weighted.T @ points)
    return Spline(t, c[:, 0], c[:, 1])


@lru_cache(maxsize=256)
def _stiffness(count: int) -> Array:
    """Return the matrix (count, count) of the cost of bends between neighbouring coefficients."""
    bend = np.diff(np.eye(count), 2, axis=0)
    return np.asarray(STIFFNESS * bend.T @ bend + 1e-9 * np.eye(count))


class CableEnding(Enum):
    """How a cable ends in a picture."""

    TIP = "tip"
    TRUNCATED = "truncated"
    HIDDEN = "hidden"


@dataclass(frozen=True, eq=False)
class Tip:
    """One of a cable's two ends.

    Attributes:
        point: (2,) the outermost point of the centreline [px].
        outward: (2,) unit vector along the cable and out of it.
        end: whether the cable ends there, leaves the picture, or goes on unseen.
    """

    point: Array
    outward: Array
    end: CableEnding


@dataclass(frozen=True, eq=False)
class DetectedCable:
    """A cable in a picture.

    Attributes:
        centreline: (n, 2) from the first tip to the last [px].
        spline: the centreline as a B-spline over 0 to 1.
        tips: the first and the last.
        width: [px].
        colour: mean, RGB 0 to 255.
        confidence: 0 to 1: the probability that this is one cable and all of it.
        warnings: the reasons why this cable may be wrong.
    """

    centreline: Array
    spline: Spline
    tips: tuple[Tip, Tip]
    width: float
    colour: tuple[float, float, float]
    confidence: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Crossing:
    """Where two strands cross; a cable that crosses itself is both.

    Attributes:
        point: (2,) [px].
        upper, lower: indices of the cables.
        upper_at, lower_at: the splines' parameters, 0 to 1.
        confidence: 0 to 1 that the upper one is on top.
    """

    point: Array
    upper: int
    lower: int
    upper_at: float
    lower_at: float
    confidence: float


@dataclass(frozen=True, eq=False)
class Detection:
    """All cables of a picture.

    `warnings` are the reasons why the result may be wrong, those of its cables included. A result
    without any is reliable.

    Attributes:
        cables: the longest first.
        crossings: where they cross.
    """

    cables: tuple[DetectedCable, ...]
    crossings: tuple[Crossing, ...]
    warnings: tuple[str, ...]


COLOURS = ((40, 200, 60), (230, 60, 220), (20, 190, 230), (250, 160, 20), (120, 110, 250))
ENDS = {
    CableEnding.TIP: (255, 40, 40),
    CableEnding.TRUNCATED: (40, 90, 255),
    CableEnding.HIDDEN: (255, 200, 0),
}
PAPER, INK = (255, 255, 255), (20, 20, 20)
SHIFT = 4  # sub-pixel bits of OpenCV's drawing functions


def sketch(rgb: Pixels, found: Detection) -> Pixels:
    """Return a picture with the centrelines, ends (a ring each) and crossings (upper number)."""
    drawn = rgb.copy()
    unit = max(1.0, max(rgb.shape[:2]) / 640)
    for i, cable in enumerate(found.cables):
        line = _fixed(cable.centreline).reshape(-1, 1, 2)
        for colour, width in ((INK, 3.0), (COLOURS[i % len(COLOURS)], 1.4)):
            cv2.polylines(drawn, [line], False, colour, round(width * unit), cv2.LINE_AA, SHIFT)
        for tip in cable.tips:
            _ring(drawn, tip.point, 6 * unit, ENDS[tip.end], unit=unit)
        _note(drawn, f"{i}", cable.tips[0].point + 9 * unit, unit)
    for crossing in found.crossings:
        _ring(drawn, crossing.point, 4 * unit, PAPER, unit=unit)
        sure = "" if crossing.confidence > 0.5 else "?"
        _note(drawn, f"{crossing.upper}{sure}", crossing.point + 6 * unit, unit)
    return drawn


def _fixed(points: Array) -> Pixels:
    return np.rint(np.asarray(points) * 2**SHIFT).astype(np.int32)


def _ring(drawn: Pixels, at: Array, radius: float, colour: tuple[int, ...], unit: float) -> None:
    place = tuple(_fixed(at).tolist())
    cv2.circle(
        drawn, place, round(radius * 2**SHIFT), colour, max(1, round(unit)), cv2.LINE_AA, SHIFT
    )


def _note(drawn: Pixels, text: str, at: Array, unit: float) -> None:
    place = (round(float(at[0])), round(float(at[1])))
    for colour, width in ((INK, 3), (PAPER, 1)):
        cv2.putText(
            drawn,
            text,
            place,
            cv2.FONT_HERSHEY_SIMPLEX,
            0.4 * unit,
            colour,
            round(width * unit),
            cv2.LINE_AA,
        )
