"""Random cables on a table: smooth curves, and which strand lies on top where two cross.

A scene is kept when a person could read it: every loose tip lies clear of other strands, strands
cross at 20 degrees or more, crossings lie apart, and strands touch nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

STEP_PX = 1.0
MARGIN_PX = 14.0
MIN_CROSSING_SINE = 0.34  # 20 degrees
MIN_BEND_WIDTHS = 3.0  # the least radius of a bend
TIP_CLEARANCE_WIDTHS = 2.5
CROSSINGS_APART_WIDTHS = 4.0
TOUCH_WIDTHS = 1.25
CROSSING_REACH_WIDTHS = 4.5
TRIES = 400


@dataclass(frozen=True, eq=False)
class CableCurve:
    """A cable's true shape.

    Attributes:
        points: (n, 2) centreline in steps of 1 px [px]; it may leave the picture.
        width: [px].
    """

    points: Array
    width: float


@dataclass(frozen=True, eq=False)
class TrueCrossing:
    """Where one strand lies on another.

    Attributes:
        point: (2,) [px].
        upper, lower: indices of the cables.
        upper_index, lower_index: of the nearest points on them.
    """

    point: Array
    upper: int
    lower: int
    upper_index: int
    lower_index: int


def random_curve(
    random: np.random.Generator, size: tuple[int, int], width: float, *, leaves: bool
) -> CableCurve:
    """Return a curve within a picture of size (width, height) that may begin outside of it."""
    limit = np.array(size, float) - 1
    while True:
        count = int(random.uniform(0.4, 1.0) * size[0] / STEP_PX)
        arc = np.arange(count) * STEP_PX
        bend = np.zeros(count)
        for _ in range(4):
            wave = random.uniform(120, 700)
            bend += random.normal(0, 0.006) * np.sin(2 * np.pi * (arc / wave + random.uniform()))
        sharpest = 1.0 / (MIN_BEND_WIDTHS * width)
        bend = np.clip(bend + random.normal(0, 0.002), -sharpest, sharpest)
        heading = random.uniform(0, 2 * np.pi) + np.cumsum(bend) * STEP_PX
        points = np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]) * STEP_PX, axis=0)
        inner = MARGIN_PX + width
        if leaves:
            points += _on_border(random, limit) - points[len(points) // 8]
            head = points[: len(points) // 8 - int(width)]
            outside = np.all(np.any((head < -width) | (head > limit + width), axis=1)[:-20])
            tail = points[len(points) // 8 + 40 :]
            if outside and np.all((tail > inner) & (tail < limit - inner)):
                return CableCurve(points, width)
        else:
            span = np.ptp(points, axis=0)
            room = limit - 2 * inner - span
            if np.all(room > 0):
                points += inner + random.uniform(0, 1, 2) * room - points.min(axis=0)
                return CableCurve(points, width)


def _on_border(random: np.random.Generator, limit: Array) -> Array:
    side = random.integers(4)
    place = random.uniform(0.15, 0.85, 2) * limit
    place[side % 2] = 0.0 if side < 2 else limit[side % 2]
    return place


def random_cables(
    random: np.random.Generator,
    size: tuple[int, int],
    count: int,
    widths: tuple[float, float],
    leaving: float,
) -> tuple[tuple[CableCurve, ...], tuple[TrueCrossing, ...]]:
    """Return cables that a person could distinguish, and their crossings.

    Args:
        random: the source of chance.
        size: (width, height) of the picture [px].
        count: of cables.
        widths: the least and the greatest [px].
        leaving: share of the cables that leave the picture.
    """
    while True:
        cables: list[CableCurve] = []
        for _ in range(TRIES):
            leaves = bool(random.uniform() < leaving)
            cable = random_curve(random, size, random.uniform(*widths), leaves=leaves)
            crossings = readable_crossings([*cables, cable], random)
            if crossings is None:
                continue
            cables.append(cable)
            if len(cables) == count:
                return tuple(cables), crossings


def readable_crossings(
    cables: list[CableCurve], random: np.random.Generator
) -> tuple[TrueCrossing, ...] | None:
    """Return the crossings of cables, the upper strand drawn by lot; None if one is unreadable."""
    found: list[TrueCrossing] = []
    for a in range(len(cables)):
        for b in range(a, len(cables)):
            more = _pair_crossings(cables, a, b, random)
            if more is None:
                return None
            found += more
    widest = max(c.width for c in cables)
    places = np.array([c.point for c in found]).reshape(-1, 2)
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1) + 1e9 * np.eye(len(places))
    if len(found) > 1 and apart.min() < CROSSINGS_APART_WIDTHS * widest:
        return None
    for cable in cables:
        for tip in (cable.points[0], cable.points[-1]):
            near = np.linalg.norm(places - tip, axis=1) < TIP_CLEARANCE_WIDTHS * widest * 1.5
            if near.any():
                return None
    return tuple(found)


def _pair_crossings(
    cables: list[CableCurve], a: int, b: int, random: np.random.Generator
) -> list[TrueCrossing] | None:
    p, q = cables[a].points, cables[b].points
    mean_width = (cables[a].width + cables[b].width) / 2
    crossings = []
    places = []
    for i, j, sine in intersections(p, q):
        if a == b and j - i < 6 * mean_width:
            continue
        if sine < MIN_CROSSING_SINE:
            return None
        first_up = bool(random.uniform() < 0.5)
        places.append(p[i])
        up, low = ((a, i), (b, j)) if first_up else ((b, j), (a, i))
        crossings.append(TrueCrossing(p[i], up[0], low[0], up[1], low[1]))
    return crossings if _apart_elsewhere(p, q, a == b, mean_width, places) else None


def _apart_elsewhere(p: Array, q: Array, same: bool, width: float, places: list[Array]) -> bool:
    """Return whether two strands touch only near their crossings, and tips nowhere."""
    i, j = np.arange(0, len(p), 3), np.arange(0, len(q), 3)
    gaps = np.linalg.norm(p[i][:, None] - q[j][None], axis=-1)
    if same:
        along = np.abs(i[:, None] - j[None]) * STEP_PX
        gaps = np.where(along < np.pi * MIN_BEND_WIDTHS * width, 1e9, gaps)
    clear = TIP_CLEARANCE_WIDTHS * width
    if min(gaps[0].min(), gaps[-1].min(), gaps[:, 0].min(), gaps[:, -1].min()) < clear:
        return False
    touching = p[i][np.any(gaps < TOUCH_WIDTHS * width, axis=1)]
    if not len(touching):
        return True
    if not places:
        return False
    reach = np.linalg.norm(touching[:, None] - np.array(places)[None], axis=-1).min(axis=1)
    return bool(np.all(reach < CROSSING_REACH_WIDTHS * width))


def intersections(p: Array, q: Array) -> list[tuple[int, int, float]]:
    """Return the indices at which polylines (n, 2) and (m, 2) cross, with the sine of the angle."""
    u, v = np.diff(p, axis=0), np.diff(q, axis=0)
    base = q[None, :-1] - p[:-1, None]
    cross = u[:, None, 0] * v[None, :, 1] - u[:, None, 1] * v[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (base[..., 0] * v[None, :, 1] - base[..., 1] * v[None, :, 0]) / cross
        t = (base[..., 0] * u[:, None, 1] - base[..., 1] * u[:, None, 0]) / cross
    hits = np.argwhere((s >= 0) & (s < 1) & (t >= 0) & (t < 1))
    if p is q:
        hits = hits[hits[:, 1] > hits[:, 0] + 2]
    sines = [abs(cross[i, j]) / np.linalg.norm(u[i]) / np.linalg.norm(v[j]) for i, j in hits]
    return [(int(i), int(j), float(sine)) for (i, j), sine in zip(hits, sines, strict=True)]
