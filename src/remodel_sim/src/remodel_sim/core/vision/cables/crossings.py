"""Where centrelines cross, and which strand lies on top.

The upper strand's edges go through the crossing; the lower one's stop. Between cables of different
colours the colour at the crossing tells as well.
"""

from __future__ import annotations

import itertools

import cv2
import numpy as np

from remodel_sim.core.geometry import Array
from remodel_sim.core.vision.cables.model import Cable, Crossing
from remodel_sim.core.vision.pixels import Pixels

# Every so many points of a centreline are intersected.
STRIDE = 4
# A strand crosses its own cable only this far along it [widths].
OWN_WIDTHS = 6.0
# Samples along a strand over a crossing, and across it around both edges [widths].
ALONG = np.linspace(-1, 1, 9)
EDGE = np.linspace(-0.25, 0.25, 5)
ACROSS = np.concatenate([EDGE - 0.5, EDGE + 0.5])
# How far from a crossing a strand shows its usual edges [widths of both].
AWAY_WIDTHS = 1.2
# Evidence from which the answer is sure.
SURE = 0.5
# Difference of colour from which it tells alone [grey levels].
COLOUR_TELLS = 60.0


def find_crossings(rgb: Pixels, cables: list[Cable]) -> tuple[Crossing, ...]:
    """Return the crossings of cables with each other and themselves."""
    found = []
    coarse = [cable.centreline[::STRIDE] for cable in cables]
    boxes = [(line.min(axis=0), line.max(axis=0)) for line in coarse]
    for a, b in itertools.combinations_with_replacement(range(len(cables)), 2):
        if np.any(boxes[a][0] > boxes[b][1]) or np.any(boxes[b][0] > boxes[a][1]):
            continue
        apart = OWN_WIDTHS * cables[a].width if a == b else 0.0
        for i, j in intersections(coarse[a], coarse[b]):
            at_a, at_b = i * STRIDE, j * STRIDE
            if a == b and at_b - at_a < apart / 2:
                continue
            found.append(_crossing(rgb, cables, (a, at_a), (b, at_b)))
    return tuple(found)


def intersections(p: Array, q: Array) -> list[tuple[float, float]]:
    """Return where polylines (n, 2) and (m, 2) cross, as indices with fractions.

    A polyline and itself: each place once, the smaller index first.
    """
    u, v = np.diff(p, axis=0), np.diff(q, axis=0)
    base = q[None, :-1] - p[:-1, None]
    cross = u[:, None, 0] * v[None, :, 1] - u[:, None, 1] * v[None, :, 0]
    cross = np.where(np.abs(cross) < 1e-9, np.inf, cross)
    s = (base[..., 0] * v[None, :, 1] - base[..., 1] * v[None, :, 0]) / cross
    t = (base[..., 0] * u[:, None, 1] - base[..., 1] * u[:, None, 0]) / cross
    hits = np.argwhere((s >= 0) & (s < 1) & (t >= 0) & (t < 1) & np.isfinite(cross))
    if p is q:
        hits = hits[hits[:, 1] > hits[:, 0] + 1]
    return [(float(i + s[i, j]), float(j + t[i, j])) for i, j in hits]


def _crossing(
    rgb: Pixels, cables: list[Cable], first: tuple[int, float], second: tuple[int, float]
) -> Crossing:
    """Return the crossing of two strands, each the number of a cable and an index on it."""
    strands = [_Strand(cables[number].centreline, index) for number, index in (first, second)]
    widths = [cables[number].width for number, _ in (first, second)]
    cross = strands[0].heading[0] * strands[1].heading[1]
    cross -= strands[0].heading[1] * strands[1].heading[0]
    sine = max(abs(float(cross)), 0.3)
    evidence = 0.0
    for k, sign in ((0, 1.0), (1, -1.0)):
        inside = 0.35 * widths[1 - k] / sine
        away = round(AWAY_WIDTHS * (widths[0] + widths[1]) / sine)
        usual = [strands[k].moved(step).contrast(rgb, widths[k], inside) for step in (-away, away)]
        evidence += sign * strands[k].contrast(rgb, widths[k], inside) / max(*usual, 1.0)
    colours = [np.array(cables[number].colour) for number, _ in (first, second)]
    apart = float(np.linalg.norm(colours[0] - colours[1]))
    if first[0] != second[0] and apart > 1.0:
        seen = _colour_at(rgb, strands[0].point, min(widths))
        nearer = [float(np.linalg.norm(seen - colour)) for colour in colours]
        evidence += (nearer[1] - nearer[0]) / apart * min(apart / COLOUR_TELLS, 2.0)
    upper, lower = (first, second) if evidence >= 0 else (second, first)
    return Crossing(
        strands[0].point,
        upper[0],
        lower[0],
        upper[1] / (len(cables[upper[0]].centreline) - 1),
        lower[1] / (len(cables[lower[0]].centreline) - 1),
        min(abs(evidence) / SURE, 1.0),
    )


class _Strand:
    """A polyline (n, 2) near one of its points."""

    def __init__(self, line: Array, index: float) -> None:
        self._line = line
        self._index = min(max(index, 1.0), len(line) - 2.0)
        places = np.arange(len(line))
        self.point = np.array([np.interp(self._index, places, line[:, i]) for i in (0, 1)])
        whole = round(self._index)
        way = line[min(whole + 2, len(line) - 1)] - line[max(whole - 2, 0)]
        self.heading = way / np.hypot(*way)

    def moved(self, pixels: float) -> _Strand:
        """Return the strand some way on."""
        step = float(np.hypot(*(self._line[1] - self._line[0])))
        return _Strand(self._line, self._index + pixels / step)

    def contrast(self, rgb: Pixels, width: float, reach: float) -> float:
        """Return how much the colour changes across its edges, over a length of 2 reach [px]."""
        normal = np.array([-self.heading[1], self.heading[0]])
        along = self.point + (reach * ALONG)[:, None] * self.heading
        grid = (along[:, None] + (width * ACROSS)[:, None] * normal).astype(np.float32)
        colours = cv2.remap(
            rgb, grid[..., 0], grid[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.float32)
        change = np.linalg.norm(np.diff(colours.mean(axis=0), axis=0), axis=1)
        return float(change.sum() - change[len(EDGE) - 1])


def _colour_at(rgb: Pixels, point: Array, width: float) -> Array:
    """Return the mean colour of a disc of a third of a width around a point (2,)."""
    offsets = np.linspace(-0.33, 0.33, 5) * width
    x = np.repeat(point[0] + offsets, 5).astype(np.float32)
    y = np.tile(point[1] + offsets, 5).astype(np.float32)
    picked = cv2.remap(rgb, x[None], y[None], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picked[0].mean(axis=0), np.float64)
