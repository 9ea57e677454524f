"""Cubic B-splines through weighted points, by least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_sim.core.geometry import Array
from remodel_sim.core.vision.cables.robust import limited

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
    columns = span[:, None] - DEGREE + np.arange(DEGREE + 1)
    np.put_along_axis(full, columns, values, axis=1)
    return full


def fit(points: Array, weights: Array, spacing: float) -> Spline:
    """Return the spline nearest to points (m, 2) with weights (m,), knots `spacing` apart [px]."""
    arc = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    u = arc / arc[-1]
    pieces = max(1, round(arc[-1] / spacing))
    inner = np.arange(1, pieces) / pieces
    t = np.concatenate([np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)])
    rows = basis(t, u)
    count = rows.shape[1]
    bend = np.diff(np.eye(count), 2, axis=0)
    weighted = rows * weights[:, None]
    density = max(float(weights.sum()), 1.0) / count
    normal = rows.T @ weighted + STIFFNESS * density * bend.T @ bend
    c = np.linalg.solve(normal + 1e-9 * np.eye(count), weighted.T @ points)
    return Spline(t, c[:, 0], c[:, 1])
