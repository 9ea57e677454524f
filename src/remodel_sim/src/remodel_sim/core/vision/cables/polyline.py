"""Polylines (n, 2): length, even steps, smoothing, and the curve across a gap."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from remodel_sim.core.geometry import Array


def arc_lengths(points: Array) -> Array:
    """Return each point's distance from the first along a polyline (n,)."""
    steps = np.diff(points, axis=0)
    return np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])


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
    keep = np.concatenate([[True], np.diff(arc) > 1e-9])
    arc, points = arc[keep], points[keep]
    even = np.linspace(0, arc[-1], max(4, round(arc[-1] / step) + 1))
    return np.column_stack([np.interp(even, arc, points[:, 0]), np.interp(even, arc, points[:, 1])])


def smooth(points: Array, sigma: float) -> Array:
    """Return a polyline smoothed by a Gaussian of `sigma` points; its ends stay."""
    reach = min(max(1, int(2.5 * sigma)), len(points) - 1)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    before = 2 * points[0] - points[reach:0:-1]
    after = 2 * points[-1] - points[-2 : -reach - 2 : -1]
    padded = np.vstack([before, points, after])
    return np.column_stack([np.convolve(padded[:, i], kernel, "valid") for i in (0, 1)])


def normals(points: Array) -> Array:
    """Return the unit normals (n, 2) of a polyline: its tangents turned from x towards y."""
    before, after = np.vstack([points[:1], points[:-1]]), np.vstack([points[1:], points[-1:]])
    tangent = after - before
    tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-9)[:, None]
    return np.column_stack([-tangent[:, 1], tangent[:, 0]])


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
