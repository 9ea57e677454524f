"""Cubic B-splines through weighted points, by least squares."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from remodel_vision.cables.curves.polyline import arc_lengths
from remodel_vision.cables.curves.robust_statistics import limited
from remodel_work.geometry import Array

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
