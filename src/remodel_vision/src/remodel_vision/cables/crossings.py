"""Where centrelines cross, and which strand lies on top.

Each strand has an appearance before and after the crossing: its colour, and across it its lit side,
its dark side and its highlight. The crossing shows the appearance of the upper one.
"""

from __future__ import annotations

import itertools
import math

import cv2
import numpy as np

from remodel_vision.cables.lines import limited
from remodel_vision.cables.model import Crossing, DetectedCable
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# Every so many points of a centreline are intersected.
STRIDE = 4
# A strand crosses its own cable only this far along it [widths].
OWN_WIDTHS = 6.0
# Samples across a strand, free of its edges [widths].
ACROSS = np.linspace(-0.34, 0.34, 7)
# Where a strand shows its usual appearance: so far from a crossing [mean widths over the sine].
AWAY = np.array([-1.8, -1.4, -1.0, 1.0, 1.4, 1.8])
# Strands are taken to cross at least at this sine.
LEAST_SINE = 0.25
# Light changes over a crossing by these factors.
GAIN = (0.8, 1.25)
# The square of colours that differ by noise alone [grey levels].
NOISE = 27.0
# Evidence from which the answer is sure.
SURE = 0.25


def find_crossings(rgb: Pixels, cables: list[DetectedCable]) -> tuple[Crossing, ...]:
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
    # On which side of each line through a segment of one the points of the other lie.
    sides_q, sides_p = _sides(p, q), _sides(q, p).T
    hits = (sides_q[:, :-1] > 0) != (sides_q[:, 1:] > 0)
    hits &= (sides_p[:-1] > 0) != (sides_p[1:] > 0)
    if p is q:
        hits = np.triu(hits, 2)
    found = []
    for i, j in zip(*np.nonzero(hits), strict=True):
        s = sides_p[i, j] / (sides_p[i, j] - sides_p[i + 1, j])
        t = sides_q[i, j] / (sides_q[i, j] - sides_q[i, j + 1])
        found.append((float(i + s), float(j + t)))
    return found


def _sides(p: Array, q: Array) -> Array:
    """Return the cross products (n - 1, m) of p's segments with the vectors to q's points.

    Positive on one side of a segment's line, negative on the other.
    """
    normal = (p[1:] - p[:-1])[:, ::-1] * (-1.0, 1.0)
    return np.asarray(normal @ q.T - np.einsum("ij,ij->i", normal, p[:-1])[:, None])


def _crossing(
    rgb: Pixels, cables: list[DetectedCable], first: tuple[int, float], second: tuple[int, float]
) -> Crossing:
    """Return the crossing of two strands, each the number of a cable and an index on it."""
    widths = np.array([cables[number].width for number, _ in (first, second)])
    lines = [cables[number].centreline for number, _ in (first, second)]
    indices = (first[1], second[1])
    (point,), _ = _along(lines[0], np.array([indices[0]]))
    across = np.vstack([_along(lines[k], np.array([indices[k]]))[1] for k in (0, 1)])
    sine = across[0, 0] * across[1, 1] - across[0, 1] * across[1, 0]
    sine = math.copysign(max(abs(sine), LEAST_SINE), sine)
    # The columns of the inverse of the two normals: a step of 1 px across one strand, along the
    # other.
    (a, b), (c, d) = across.tolist()
    steps = np.array([[d, -c], [-b, a]]) / sine
    offsets = widths[:, None] * ACROSS
    grid = offsets[0][:, None, None] * steps[0] + offsets[1][None, :, None] * steps[1]
    away = AWAY * float(widths.mean()) / abs(sine)
    places = [(point + grid).reshape(-1, 2)]
    for line, index, offset in zip(lines, indices, offsets, strict=True):
        spacing = math.dist(line[0], line[1])
        points, normals = _along(line, index + away / spacing)
        places.append((points[:, None] + offset[:, None] * normals[:, None]).reshape(-1, 2))
    seen = _colours(rgb, np.vstack(places))
    shown, usual = np.split(seen, [ACROSS.size**2])
    shown = shown.reshape(ACROSS.size, ACROSS.size, 3)
    appearances = usual.reshape(2, AWAY.size, ACROSS.size, 3).mean(axis=1)
    misfit = _misfit(shown, appearances[0][:, None]), _misfit(shown, appearances[1][None, :])
    evidence = (misfit[1] - misfit[0]) / (misfit[0] + misfit[1] + NOISE)
    upper, lower = (first, second) if evidence >= 0 else (second, first)
    return Crossing(
        point=point,
        upper=upper[0],
        lower=lower[0],
        upper_at=upper[1] / (len(cables[upper[0]].centreline) - 1),
        lower_at=lower[1] / (len(cables[lower[0]].centreline) - 1),
        confidence=min(abs(evidence) / SURE, 1.0),
    )


def _along(line: Array, indices: Array) -> tuple[Array, Array]:
    """Return the points (m, 2) of a polyline (n, 2) at fractional indices, and unit normals."""
    inner = limited(indices, 1.0, len(line) - 3.0)
    whole = inner.astype(np.intp)
    points = line[whole] + (inner - whole)[:, None] * (line[whole + 1] - line[whole])
    ways = line[whole + 2] - line[whole - 1]
    ways /= np.sqrt(np.square(ways) @ np.ones(2))[:, None]
    return points, ways[:, ::-1] * (-1.0, 1.0)


def _misfit(shown: Pixels, appearance: Pixels) -> float:
    """Return the mean square difference to an appearance, dimmed or lit a little."""
    appearance = np.broadcast_to(appearance, shown.shape)
    gain = float(np.vdot(shown, appearance)) / max(float(np.vdot(appearance, appearance)), 1.0)
    left = shown - min(max(gain, GAIN[0]), GAIN[1]) * appearance
    return float(np.vdot(left, left)) * 3 / shown.size


def _colours(rgb: Pixels, places: Array) -> Pixels:
    """Return a picture's colours at places (n, 2)."""
    at = places.astype(np.float32)[None]
    return cv2.remap(
        rgb, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )[0].astype(np.float32)
