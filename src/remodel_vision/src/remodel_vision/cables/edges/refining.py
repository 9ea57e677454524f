"""Move rough centrelines to the middle between the edges, and learn the widths.

The first round searches for edges generously and learns the width, the others near half of it.
A profile's centre is where its edges say, as far as they agree with the cable's width: at
crossings, in shadows and beside other cables one edge or none counts, and the curve carries on from
its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_vision.cables.curves.polyline import normals, resample, smooth
from remodel_vision.cables.curves.robust_statistics import median
from remodel_vision.cables.edges.cross_sections import CrossSections, find_edges
from remodel_vision.pixels import Pixels
from remodel_work.geometry import Array

# In each round: how far from half a width edges may lie, and how far their distance from the width
# [widths]. A mask may show little more than the lit half of a cable.
ROUNDS = ((0.35, 0.9), (0.12, 0.35))
# Profiles of the first round are longer than the mask's width by this factor.
FIRST_ESTIMATE = 1.25
# An edge counts from this share of the cable's usual contrast on.
FAINT = 0.35
# Profiles are this far apart [widths], and at least [px].
SPACING_WIDTHS, SPACING_PX = 0.35, 2.0
# In the first round they are this much farther apart.
FIRST_SPACING = 2.0
MIN_SECTIONS = 6


@dataclass(frozen=True, eq=False)
class Refined:
    """A centreline between edges.

    Attributes:
        points: (n, 2) [px].
        weight: (n,) how many of the two edges say so, 0 to 2.
        width: [px].
        spread: of the width along the cable [widths].
        sections: its cross-section profiles.
    """

    points: Array
    weight: Array
    width: float
    spread: float
    sections: CrossSections


def refine(rgb: Pixels, lines: list[Array], widths: list[float]) -> list[Refined | None]:
    """Refine rough centrelines (n, 2) [px] of rough widths [px]; None where no edges are found."""
    lines = [
        resample(line, FIRST_SPACING * _spacing(width))
        for line, width in zip(lines, widths, strict=True)
    ]
    widths = [FIRST_ESTIMATE * width for width in widths]
    refined: list[Refined | None] = []
    for limits in ROUNDS:
        refined = _round(rgb, lines, widths, limits)
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
    """Find the edges of all cables at once, and move their centrelines."""
    counts = [len(line) for line in lines]
    across = [normals(line) for line in lines]
    sections = find_edges(
        rgb, np.vstack(lines), np.vstack(across), np.repeat(widths, counts), counts=np.array(counts)
    )
    refined, start = [], 0
    for line, normal, width in zip(lines, across, widths, strict=True):
        own = sections.part(slice(start, start + len(line)))
        refined.append(_centre(line, normal, own, width, limits=limits))
        start += len(line)
    return refined


def _centre(
    line: Array, normal: Array, sections: CrossSections, width: float, limits: tuple[float, float]
) -> Refined | None:
    """Move a centreline (n, 2) along its normals to the middle between its edges."""
    found = np.isfinite(sections.edges)
    if np.count_nonzero(found) < 2 * MIN_SECTIONS:
        return None
    usual = max(median(sections.contrast[found]), 1e-6)
    strength = found * np.minimum(sections.contrast / usual, 1)
    edges = np.where(found, sections.edges, 0.0)
    measured = edges[:, 1] - edges[:, 0]
    weaker = np.minimum(strength[:, 0], strength[:, 1])
    plausible = measured[(weaker > FAINT) & (np.abs(measured / width - 1) < limits[1])]
    if len(plausible) < MIN_SECTIONS:
        return None
    width = median(plausible)
    spread = median(np.abs(plausible / width - 1))
    trust = limits[0] * width
    agree = np.exp(np.square(measured - width) * (-0.5 / trust**2))
    shifts = edges + np.array([0.5, -0.5]) * width
    near = np.exp(np.square(shifts) * (-0.5 / (2 * trust) ** 2))
    shares = strength * (strength > FAINT) * np.maximum(agree[:, None], 0.5 * near)
    weight = shares[:, 0] + shares[:, 1]
    good = np.flatnonzero(weight > FAINT)
    if len(good) < MIN_SECTIONS:
        return None
    shift = (shares[good, 0] * shifts[good, 0] + shares[good, 1] * shifts[good, 1]) / weight[good]
    offset = np.interp(np.arange(len(line)), good, shift)
    points = line + offset[:, None] * normal
    return Refined(
        points=points,
        weight=weight * (weight > FAINT),
        width=width,
        spread=spread,
        sections=sections,
    )
