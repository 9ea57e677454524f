"""Move rough centrelines to the middle between the edges, and learn the widths.

The first round looks for edges generously and learns the width, the others near half of it.
A rib's centre is where its edges say, as far as they agree with the cable's width: at crossings, in
shadows and beside other cables one edge or none counts, and the curve carries on from its
neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_sim.core.geometry import Array
from remodel_sim.core.vision.cables.polyline import normals, resample, smooth
from remodel_sim.core.vision.cables.ribs import Ribs, find_edges
from remodel_sim.core.vision.cables.robust import median
from remodel_sim.core.vision.pixels import Pixels

# In each round: how far from half a width edges may lie, and how far their distance from the width
# [widths]. A mask may show little more than the lit half of a cable.
ROUNDS = ((0.35, 0.9), (0.12, 0.35))
# Ribs of the first round are longer than the mask's width by this factor.
FIRST_GUESS = 1.25
# An edge counts from this share of the cable's usual contrast on.
FAINT = 0.35
# Ribs are this far apart [widths], and at least [px].
SPACING_WIDTHS, SPACING_PX = 0.35, 2.0
# In the first round they are this much farther apart.
FIRST_SPACING = 2.0
MIN_RIBS = 6


@dataclass(frozen=True, eq=False)
class Refined:
    """A centreline between edges.

    Attributes:
        points: (n, 2) [px].
        weight: (n,) how many of the two edges say so, 0 to 2.
        width: [px].
        spread: of the width along the cable [widths].
        ribs: what was seen across it.
    """

    points: Array
    weight: Array
    width: float
    spread: float
    ribs: Ribs


def refine(rgb: Pixels, lines: list[Array], widths: list[float]) -> list[Refined | None]:
    """Refine rough centrelines (n, 2) [px] of rough widths [px]; None where no edges are found."""
    lines = [
        resample(smooth(resample(line, 1.0), 0.5 * width), FIRST_SPACING * _spacing(width))
        for line, width in zip(lines, widths, strict=True)
    ]
    widths = [FIRST_GUESS * width for width in widths]
    refined: list[Refined | None] = []
    for tolerance, doubt in ROUNDS:
        refined = _round(rgb, lines, widths, (tolerance, doubt))
        lines = [
            resample(smooth(r.points, 1.5), _spacing(r.width)) if r else line
            for r, line in zip(refined, lines, strict=True)
        ]
        widths = [r.width if r else w for r, w in zip(refined, widths, strict=True)]
    return refined


def _spacing(width: float) -> float:
    return max(SPACING_PX, SPACING_WIDTHS * width)


def _round(
    rgb: Pixels, lines: list[Array], widths: list[float], limits: tuple[float, float]
) -> list[Refined | None]:
    across = [normals(line) for line in lines]
    each = np.repeat(np.array(widths), [len(line) for line in lines])
    cable = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    ribs = find_edges(rgb, np.vstack(lines), np.vstack(across), each, cable)
    refined, start = [], 0
    for line, normal, width in zip(lines, across, widths, strict=True):
        own = ribs.part(slice(start, start + len(line)))
        refined.append(_centre(line, normal, own, width, limits))
        start += len(line)
    return refined


def _centre(
    line: Array, normal: Array, ribs: Ribs, width: float, limits: tuple[float, float]
) -> Refined | None:
    """Move a centreline (n, 2) along its normals to where its ribs say."""
    found = np.isfinite(ribs.edges)
    if found.sum() < 2 * MIN_RIBS:
        return None
    usual = max(median(ribs.contrast[found]), 1e-6)
    strength = np.where(found, np.minimum(ribs.contrast / usual, 1), 0.0)
    edges = np.where(found, ribs.edges, 0.0)
    measured = edges[:, 1] - edges[:, 0]
    plausible = (strength.min(axis=1) > FAINT) & (np.abs(measured / width - 1) < limits[1])
    if plausible.sum() < MIN_RIBS:
        return None
    width = median(measured[plausible])
    spread = median(np.abs(measured[plausible] / width - 1))
    trust = limits[0] * width
    agree = np.exp(-0.5 * ((measured - width) / trust) ** 2)
    shifts = edges + np.array([0.5, -0.5]) * width
    near = np.exp(-0.5 * (shifts / (2 * trust)) ** 2)
    shares = np.where(strength > FAINT, strength, 0.0) * np.maximum(agree[:, None], 0.5 * near)
    weight = shares.sum(axis=1)
    good = weight > FAINT
    if good.sum() < MIN_RIBS:
        return None
    places = np.arange(len(line))
    offset = np.sum(shares * shifts, axis=1) / np.maximum(weight, 1e-6)
    offset = np.interp(places, places[good], offset[good])
    return Refined(line + offset[:, None] * normal, weight * good, width, spread, ribs)
