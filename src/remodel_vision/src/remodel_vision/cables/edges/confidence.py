"""Whether a centreline is a cable, and how sure it is that it is one cable and all of it.

The limits of the first, five factors, were read off some 600 true and 100 false centrelines in
rendered scenes (benchmarks/vision): between the two lies a wide gap for each of the factors. The
second is a logistic model, fitted to true and false answers (benchmarks/vision/fit_confidence.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_vision.cables.edges.confidence_weights import BIAS, WEIGHTS
from remodel_vision.cables.edges.cross_sections import Refined, length
from remodel_vision.cables.lines import arc_lengths, limited, median, median_colour, smooth
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# From where a factor is 0 to where it is 1.
CONTRAST_SPREADS = (2.5, 5.0)  # at the edges, in spreads of the table
CONTRAST_LEVELS = (7.0, 16.0)  # the same [grey levels]
EDGES = (0.40, 0.65)  # share of the edges that are found and agree
RIDGE = (0.30, 0.65)  # share of the sections whose two sides are alike, and unlike the cable
LENGTH_WIDTHS = (5.0, 9.0)
UNEVEN = (0.20, 0.10)  # spread of the width
# A line is rough that a Gaussian over so many profiles moves.
ROUGH_SECTIONS = 3.0
# Both edges of a profile are strong from this share of the usual contrast on.
STRONG = 0.5
END_SECTIONS = 10
SHADES = (0.4, 2.0)
# Another hue is this far from the shades of the cable's, as a share of its contrast.
OTHER_HUE = 0.5
# A shadow takes this share of the light away.
DEEP = 0.75
# From this level on a picture is overexposed [grey levels].
TOP = 250
# Two sides are alike when they differ by less than this share of the cable's contrast.
ALIKE = 0.7


@dataclass(frozen=True)
class Evidence:
    """Factors from 0 (no cable) to 1 (certainly a cable), and what they were made of.

    Attributes:
        contrast: of the edges.
        edges: how many are found and agree.
        ridge: two sides alike, and unlike the cable.
        length: for a cable of its width.
        even: how little the width varies.
        levels: the contrast itself [grey levels].
        terms: of the logistic model, by name.
    """

    contrast: float
    edges: float
    ridge: float
    length: float
    even: float
    levels: float
    terms: dict[str, float]

    @property
    def total(self) -> float:
        """All factors together: whether it is a cable."""
        return self.contrast * self.edges * self.ridge * self.length * self.even


def weigh(refined: Refined, spread: float) -> Evidence:
    """Weigh a centreline on a table whose colours have a spread [grey levels]."""
    sections = refined.sections
    rim = np.where(np.isfinite(sections.edges), sections.contrast, 0.0).min(axis=1)
    left, right = sections.beside[:, 0], sections.beside[:, 1]
    contrast = np.minimum(length(sections.middle - left), length(sections.middle - right))
    alike = float(np.mean(length(left - right) < ALIKE * contrast))
    edges = float(refined.weight.mean()) / 2
    usual = median(rim)
    long = float(arc_lengths(refined.points)[-1]) / refined.width
    own = median_colour(sections.middle)
    around = (left + right) / 2
    levels = max(median(contrast), 1.0)
    smoothed = smooth(refined.points, ROUGH_SECTIONS)
    tangents = np.diff(smoothed, axis=0)
    turns = np.abs(np.diff(np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))))
    step = long * refined.width / max(len(refined.points) - 1, 1)
    same = _same_hue(sections.middle, median_colour(sections.middle)[None], contrast)
    halves = _same_hue(sections.inside[:, 0], sections.inside[:, 1], contrast)
    return Evidence(
        contrast=min(ramp(usual / spread, CONTRAST_SPREADS), ramp(usual, CONTRAST_LEVELS)),
        edges=ramp(edges, EDGES),
        ridge=ramp(alike, RIDGE),
        length=ramp(long, LENGTH_WIDTHS),
        even=ramp(refined.spread, UNEVEN),
        levels=usual,
        terms={
            "contrast [log spreads]": math.log(usual / spread + 0.1),
            "contrast [log levels]": math.log(usual + 1),
            "edges that agree": edges,
            "sides alike": alike,
            "length [log widths]": math.log(long),
            "spread of the width": refined.spread,
            "one hue": float(same.mean()),
            "one hue at the ends": float(
                min(same[:END_SECTIONS].mean(), same[-END_SECTIONS:].mean())
            ),
            "deep shadows": float(np.mean(sections.shadow < DEEP)),
            "halves of one hue": float(halves.mean()),
            "uneven middle": median(length(sections.middle - own)) / levels,
            "uneven surroundings": median(length(around - median_colour(around))) / levels,
            "sides apart": min(median(length(left - right)) / levels, 3.0),
            "strong edges": float(np.mean(rim > STRONG * usual)),
            "rough [widths]": float(np.hypot(*(refined.points - smoothed).T).mean())
            / refined.width,
            "sharpest bend [log]": math.log(
                float(np.max(turns, initial=0.0)) * refined.width / step + 0.01
            ),
            "overexposed beside": float(np.mean(sections.beside.max(axis=2) >= TOP)),
            "softness [widths]": median(sections.softness) / refined.width,
            "softness [log px]": math.log(median(sections.softness) + 0.1),
        },
    )


def confidence(terms: dict[str, float]) -> float:
    """Return the probability that a cable is one cable and all of it, by its terms."""
    score = BIAS + sum(weight * terms[name] for name, weight in WEIGHTS.items())
    return 1 / (1 + math.exp(-min(max(score, -50.0), 50.0)))


def _same_hue(a: Array, b: Array, contrast: Pixels) -> npt.NDArray[np.bool_]:
    """Return where colours (n, 3) are shades of others."""
    shade = limited(
        np.einsum("ij,ij->i", a, b) / np.maximum(np.einsum("ij,ij->i", b, b), 1.0), *SHADES
    )
    return length(a - shade[:, None] * b) < OTHER_HUE * median(contrast)


def ramp(value: float, limits: tuple[float, float]) -> float:
    """Return 0 up to the first limit, 1 from the second on, and a straight line between."""
    return min(max((value - limits[0]) / (limits[1] - limits[0]), 0.0), 1.0)
