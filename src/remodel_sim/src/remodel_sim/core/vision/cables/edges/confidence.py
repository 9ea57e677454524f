"""The confidence that a centreline is a cable: what its cross sections show, from 0 to 1.

The limits were read off some 600 true and 100 false centrelines in rendered scenes
(benchmarks/vision): between the two lies a wide gap for each of the factors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_sim.core.vision.cables.curves.polyline import arc_lengths
from remodel_sim.core.vision.cables.curves.robust_statistics import limited, median, median_colour
from remodel_sim.core.vision.cables.edges.cross_sections import length
from remodel_sim.core.vision.cables.edges.refining import Refined
from remodel_sim.core.vision.pixels import Pixels

# From where a factor is 0 to where it is 1.
CONTRAST_SPREADS = (2.5, 5.0)  # at the edges, in spreads of the table
CONTRAST_LEVELS = (7.0, 16.0)  # the same [grey levels]
EDGES = (0.40, 0.65)  # share of the edges that are found and agree
RIDGE = (0.30, 0.65)  # share of the sections whose two sides are alike, and unlike the cable
LENGTH_WIDTHS = (5.0, 9.0)
UNEVEN = (0.20, 0.10)  # spread of the width
ONE_HUE = (0.75, 0.92)  # share of the sections that show a shade of the cable's colour
END_HUE = (0.2, 0.6)  # the same over so many sections at either end
END_SECTIONS = 10
SHADES = (0.4, 2.0)
# Another hue is this far from the shades of the cable's, as a share of its contrast.
OTHER_HUE = 0.5
# Share of the sections with a shadow on one side, deeper than that share of the light.
SHADOWS = (0.30, 0.10)
DEEP = 0.75
# Share of the sections whose two halves are of different hues: half cable, half a hard shadow.
TWO_HUES = (0.65, 0.35)
# How far the edges stretch when the picture is blurred [px], and what part of a width is harmless.
SOFT_PX = (6.2, 5.0)
SOFT_WIDTHS = 0.42
# Two sides are alike when they differ by less than this share of the cable's contrast.
ALIKE = 0.7


@dataclass(frozen=True)
class Evidence:
    """Factors from 0 (no cable) to 1 (certainly a cable).

    Attributes:
        contrast: of the edges.
        edges: how many are found and agree.
        ridge: two sides alike, and unlike the cable.
        length: for a cable of its width.
        even: how little the width varies.
        hue: how far its colour is the same all along.
        clear: of hard shadows, and of blur.
        levels: the contrast itself [grey levels].
    """

    contrast: float
    edges: float
    ridge: float
    length: float
    even: float
    hue: float
    clear: float
    levels: float

    @property
    def total(self) -> float:
        """All factors together: whether it is a cable."""
        return self.contrast * self.edges * self.ridge * self.length * self.even

    @property
    def trust(self) -> float:
        """How far a cable's outline is to be relied on."""
        return self.hue * self.clear


def weigh(refined: Refined, spread: float) -> Evidence:
    """Weigh a centreline on a table whose colours have a spread [grey levels]."""
    sections = refined.sections
    rim = np.where(np.isfinite(sections.edges), sections.contrast, 0.0).min(axis=1)
    left, right = sections.beside[:, 0], sections.beside[:, 1]
    contrast = np.minimum(length(sections.middle - left), length(sections.middle - right))
    alike = length(left - right) < ALIKE * contrast
    usual = median(rim)
    long = float(arc_lengths(refined.points)[-1]) / refined.width
    return Evidence(
        contrast=min(ramp(usual / spread, CONTRAST_SPREADS), ramp(usual, CONTRAST_LEVELS)),
        edges=ramp(float(refined.weight.mean()) / 2, EDGES),
        ridge=ramp(float(alike.mean()), RIDGE),
        length=ramp(long, LENGTH_WIDTHS),
        even=ramp(refined.spread, UNEVEN),
        hue=_of_one_hue(sections.middle, contrast),
        clear=min(
            ramp(float(np.mean(sections.shadow < DEEP)), SHADOWS),
            ramp(
                float(np.mean(_other_hue(sections.inside[:, 0], sections.inside[:, 1], contrast))),
                TWO_HUES,
            ),
            _sharp(refined),
        ),
        levels=usual,
    )


def _sharp(refined: Refined) -> float:
    """Return how far the edges are sharp, or blur in a part of the width only."""
    softness = median(refined.sections.softness)
    return 1.0 if softness < SOFT_WIDTHS * refined.width else ramp(softness, SOFT_PX)


def _of_one_hue(colours: Pixels, contrast: Pixels) -> float:
    """Return how far colours (n, 3) are shades of their median: all along, and at the ends."""
    same = ~_other_hue(colours, median_colour(colours)[None], contrast)
    ends = min(float(same[:END_SECTIONS].mean()), float(same[-END_SECTIONS:].mean()))
    return min(ramp(float(same.mean()), ONE_HUE), ramp(ends, END_HUE))


def _other_hue(a: Pixels, b: Pixels, contrast: Pixels) -> npt.NDArray[np.bool_]:
    """Return where colours (n, 3) are no shades of others."""
    shade = limited(
        np.einsum("ij,ij->i", a, b) / np.maximum(np.einsum("ij,ij->i", b, b), 1.0), *SHADES
    )
    return length(a - shade[:, None] * b) >= OTHER_HUE * median(contrast)


def ramp(value: float, limits: tuple[float, float]) -> float:
    """Return 0 up to the first limit, 1 from the second on, and a straight line between."""
    return min(max((value - limits[0]) / (limits[1] - limits[0]), 0.0), 1.0)
