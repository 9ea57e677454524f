"""Poses in KBL: a point, and a frame by the directions U and V of two of its axes."""

from __future__ import annotations

import math

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, children
from remodel_production.core.imports.shared.units import number
from remodel_production.core.production import Pose, Vector


def placed_pose(tree: KblTree, occurrence: etree._Element) -> Pose | None:
    """Return where an occurrence is placed; None if it does not say."""
    for placement in children(occurrence, "Placement"):
        position = tree.position(placement)
        if position is not None:
            return Pose(position, _orientation(_vector(placement, "U"), _vector(placement, "V")))
    return None


def _vector(placement: etree._Element, key: str) -> Vector | None:
    values = [number(child.text or "") for child in children(placement, key)]
    known = [value for value in values if value is not None]
    if len(known) != 3 or not any(known):
        return None
    x, y, z = known
    return x, y, z


def _orientation(u: Vector | None, v: Vector | None) -> tuple[float, float, float, float]:
    """Return the quaternion of a frame by its x axis and (about) its y axis; identity by default.

    Shepperd's method, by the largest of trace and diagonal (J. Guidance and Control 1(3), 1978).
    """
    if u is None or v is None:
        return 0.0, 0.0, 0.0, 1.0
    x = _unit(u)
    z = _cross(x, v)
    if not any(abs(value) > 1e-9 for value in z):
        return 0.0, 0.0, 0.0, 1.0
    z = _unit(z)
    y = _cross(z, x)
    m = tuple(zip(x, y, z, strict=True))  # rows of the matrix with the axes as columns
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0:
        s = 2 * math.sqrt(trace + 1)
        q = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
        return q[0] / s, q[1] / s, q[2] / s, s / 4
    i = max(range(3), key=lambda n: m[n][n])
    j, k = (i + 1) % 3, (i + 2) % 3
    s = 2 * math.sqrt(max(0.0, 1 + m[i][i] - m[j][j] - m[k][k]))
    parts = [0.0, 0.0, 0.0]
    parts[i], parts[j], parts[k] = s / 4, (m[j][i] + m[i][j]) / s, (m[k][i] + m[i][k]) / s
    return parts[0], parts[1], parts[2], (m[k][j] - m[j][k]) / s


def _unit(vector: Vector) -> Vector:
    norm = math.sqrt(sum(value * value for value in vector))
    return vector[0] / norm, vector[1] / norm, vector[2] / norm


def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
