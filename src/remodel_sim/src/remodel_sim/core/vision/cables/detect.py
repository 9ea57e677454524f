"""Find all cables in a picture.

A mask at low resolution says where the table is covered; its skeleton is cut into strands where
they meet; strands are joined to cables; edges at full resolution give centrelines, widths and tips
to a fraction of a pixel. What is not certain causes a warning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from remodel_sim.core.vision.cables.crossings import find_crossings
from remodel_sim.core.vision.cables.curves.polyline import arc_lengths
from remodel_sim.core.vision.cables.curves.robust_statistics import median_colour
from remodel_sim.core.vision.cables.curves.spline import fit
from remodel_sim.core.vision.cables.edges.confidence import Evidence, confidence, weigh
from remodel_sim.core.vision.cables.edges.refining import Refined, refine
from remodel_sim.core.vision.cables.ends import AXIS_FROM, find_end
from remodel_sim.core.vision.cables.model import (
    CableEnding,
    Crossing,
    DetectedCable,
    Detection,
    Tip,
)
from remodel_sim.core.vision.cables.strands.foreground import Foreground, find_foreground
from remodel_sim.core.vision.cables.strands.joining import rough_cables
from remodel_sim.core.vision.cables.strands.prior import Prior, checked_prior
from remodel_sim.core.vision.cables.warnings import (
    CLUTTERED,
    NOTHING,
    SURE,
    Notice,
    cable_warnings,
    exposure_warnings,
    over_foreign_objects,
    remainder_warnings,
    surrounding_terms,
)
from remodel_sim.core.vision.pixels import Pixels

# The foreground is found in a picture of about so many columns; in the finer one where cables are
# this thin in the first [px].
WORKING_COLUMNS = (320, 640)
THIN = 1.0
MIN_SIDE = 64
KEPT_BYTES = 8_000_000
# Knots of the splines are this far apart: a cable bends no sharper [widths], [px].
KNOTS_WIDTHS, KNOTS_PX = 3.0, 12.0
# A tip pulls the spline as much as so many edges.
TIP_WEIGHT = 3.0
# Centrelines with less evidence are no cables.
NO_CABLE = 0.15
# What is shorter than this share of the longest sure cable is a scrap of the table's grain, unless
# it is sure and its contrast at least this share of the faintest long cable's.
SCRAP_LENGTH, SCRAP_CONTRAST = 0.25, 0.5
# A second best pairing that is dearer than this is none.
SURE_MARGIN = 0.5


def detect_cables(
    rgb: Pixels,
    mask: Pixels | None = None,
    colours: Sequence[Sequence[float]] = (),
    widths: Sequence[float] = (),
    background: Pixels | None = None,
) -> Detection:
    """Find the cables in a picture (height, width, 3), RGB.

    Args:
        rgb: the picture.
        mask: (height, width), not 0 where a cable may be seen; without it everywhere.
        colours: RGB of the cables from 0 to 255; without any, cables of all colours are found.
        widths: of the cables [px]; without any, cables of all widths are found.
        background: (height, width, 3), RGB, the same view without the cables.

    Raises:
        ValueError: for another shape or type, a picture of less than 64 px, or prior knowledge
            that does not fit the picture.
    """
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3 or min(rgb.shape[:2]) < MIN_SIDE:
        raise ValueError(
            f"a picture of shape {rgb.shape} and type {rgb.dtype}; it must be (height, width, 3), "
            f"uint8, and {MIN_SIDE} px or more each way"
        )
    prior = checked_prior(rgb.shape, mask, colours, widths, background)
    _keep_memory()
    for columns in WORKING_COLUMNS:
        scale = max(1, round(max(rgb.shape[:2]) / columns))
        small = cv2.resize(rgb, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)
        foreground = find_foreground(small, prior.smaller(scale))
        if scale == 1 or foreground.half_width > THIN:
            break
    return _detect(rgb, scale, small, foreground, prior)


def _keep_memory() -> None:
    """Keep the C library from giving memory back to the system while a picture is worked on.

    Fetching it again takes as long as the arithmetic does. glibc keeps as much as twice the
    greatest block that it mapped and freed (mallopt(3), M_MMAP_THRESHOLD); others do not mind.
    """
    block = np.empty(KEPT_BYTES // 2, np.uint8)
    del block


def _detect(
    rgb: Pixels, scale: int, small: Pixels, foreground: Foreground, prior: Prior
) -> Detection:
    """Find the cables, given the foreground of a picture made `scale` times smaller."""
    rough = rough_cables(small, foreground)
    if not rough:
        why = Notice(CLUTTERED if rough is None else NOTHING)
        return _detection([], (), [*exposure_warnings(small), why])
    lines = [(r.line + 0.5) * scale - 0.5 for r in rough]
    refined = refine(rgb, lines, [r.width * scale for r in rough])
    candidates = [
        _Candidate(line, weigh(line, foreground.spread), min(r.margin, SURE_MARGIN))
        for r, line in zip(rough, refined, strict=True)
        if line is not None and prior.fits(line.width)
    ]
    kept = sorted(_without_scraps(candidates), key=lambda c: -len(c.line.points))
    cables = []
    for found in kept:
        cable = _cable(rgb, found.line)
        cables.append(replace(cable, tips=_not_over(foreground.foreign_objects, cable, scale)))
    cables = [
        replace(cable, confidence=confidence(terms))
        for cable, terms in zip(cables, _terms(rgb, kept, cables, foreground, scale), strict=True)
    ]
    notices = [
        *exposure_warnings(small),
        *cable_warnings(rgb, cables),
        *remainder_warnings(foreground, cables, scale),
    ]
    return _detection(cables, find_crossings(rgb, cables), notices)


def _terms(
    rgb: Pixels,
    candidates: list[_Candidate],
    cables: list[DetectedCable],
    foreground: Foreground,
    scale: int,
) -> list[dict[str, float]]:
    """Return the terms of each cable's confidence."""
    return [
        {
            **candidate.evidence.terms,
            "margin": candidate.margin,
            "over foreign objects": over_foreign_objects(foreground, cables[i], scale),
            **surrounding_terms(rgb, cables, i),
        }
        for i, candidate in enumerate(candidates)
    ]


def _detection(
    cables: list[DetectedCable], crossings: tuple[Crossing, ...], notices: list[Notice]
) -> Detection:
    """Return the result, each warning also with the cables that it is about."""
    own = [tuple(n.text for n in notices if i in n.cables) for i in range(len(cables))]
    return Detection(
        tuple(replace(cable, warnings=w) for cable, w in zip(cables, own, strict=True)),
        crossings,
        tuple(notice.text for notice in notices),
    )


@dataclass(frozen=True, eq=False)
class _Candidate:
    """What may be a cable: its centreline, what speaks for it, and how sure its joinings are."""

    line: Refined
    evidence: Evidence
    margin: float


def _without_scraps(candidates: list[_Candidate]) -> list[_Candidate]:
    """Return the candidates that are cables, not scraps of the table's grain."""
    sure = [c for c in candidates if c.evidence.total >= SURE]
    short = SCRAP_LENGTH * max((len(c.line.points) for c in sure), default=0)
    long = [c for c in sure if len(c.line.points) > short]
    faint = SCRAP_CONTRAST * min((c.evidence.levels for c in long), default=0)
    clear = [c for c in sure if c.evidence.levels >= faint]
    return [
        c
        for c in candidates
        if (c.evidence.total >= NO_CABLE if len(c.line.points) > short else c in clear)
    ]


def _not_over(foreign_objects: Pixels, cable: DetectedCable, scale: int) -> tuple[Tip, Tip]:
    """Return a cable's tips; one at the edge of a foreign object is hidden."""
    tips = []
    for tip in cable.tips:
        beyond = (tip.point + (cable.width + scale) * tip.outward + 0.5) / scale - 0.5
        column, row = np.clip(
            np.rint(beyond).astype(int), 0, np.array(foreign_objects.shape[::-1]) - 1
        )
        hidden = tip.end is CableEnding.TIP and foreign_objects[row, column]
        tips.append(replace(tip, end=CableEnding.HIDDEN) if hidden else tip)
    return tips[0], tips[1]


def _cable(rgb: Pixels, refined: Refined) -> DetectedCable:
    """Find the ends and fit the spline."""
    width = refined.width
    first = find_end(rgb, refined.points, width)
    last = find_end(rgb, refined.points[::-1], width)
    arc = arc_lengths(refined.points)
    near = AXIS_FROM * width
    inner = (arc > near) & (arc < arc[-1] - near)
    points = np.vstack([first.point, refined.points[inner], last.point])
    weight = np.concatenate([[TIP_WEIGHT], refined.weight[inner], [TIP_WEIGHT]])
    spline = fit(points, weight, max(KNOTS_WIDTHS * width, KNOTS_PX))
    line = spline.at(np.linspace(0, 1, max(8, int(arc[-1] / 2))))
    red, green, blue = median_colour(refined.sections.middle).tolist()
    return DetectedCable(
        centreline=line,
        spline=spline,
        tips=(first, last),
        width=width,
        colour=(red, green, blue),
        confidence=0.0,
    )
