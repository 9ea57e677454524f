"""Polylines (n, 2): length, even steps, smoothing, and the curve across a gap."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from remodel_work.geometry import Array


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
