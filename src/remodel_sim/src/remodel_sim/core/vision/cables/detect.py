"""Find all cables in a picture.

A mask at low resolution says where the table is covered; its skeleton is cut into strands where
they meet; strands are joined to cables; edges at full resolution give centrelines, widths and tips
to a fraction of a pixel. What is not certain causes a warning.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from remodel_sim.core.vision.cables.crossings import find_crossings
from remodel_sim.core.vision.cables.curves.polyline import arc_lengths
from remodel_sim.core.vision.cables.curves.robust_statistics import median_colour
from remodel_sim.core.vision.cables.curves.spline import fit
from remodel_sim.core.vision.cables.edges.confidence import Evidence, ramp, weigh
from remodel_sim.core.vision.cables.edges.refining import Refined, refine
from remodel_sim.core.vision.cables.ends import AXIS_FROM, find_end
from remodel_sim.core.vision.cables.model import CableEnding, DetectedCable, Detection, Tip
from remodel_sim.core.vision.cables.strands.foreground import Foreground, find_foreground
from remodel_sim.core.vision.cables.strands.joining import rough_cables
from remodel_sim.core.vision.cables.warnings import (
    CLUTTERED,
    NOTHING,
    SURE,
    cable_warnings,
    exposure_warnings,
    remainder_warnings,
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
# Joinings whose second best pairing is dearer by this are sure.
SURE_MARGIN = (0.0, 0.25)


def detect_cables(rgb: Pixels) -> Detection:
    """Find the cables in a picture (height, width, 3), RGB.

    Raises:
        ValueError: for another shape or type, or a picture of less than 64 px.
    """
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3 or min(rgb.shape[:2]) < MIN_SIDE:
        raise ValueError(
            f"a picture of shape {rgb.shape} and type {rgb.dtype}; it must be (height, width, 3), "
            f"uint8, and {MIN_SIDE} px or more each way"
        )
    _keep_memory()
    for columns in WORKING_COLUMNS:
        scale = max(1, round(max(rgb.shape[:2]) / columns))
        small = cv2.resize(rgb, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)
        foreground = find_foreground(small)
        if scale == 1 or foreground.half_width > THIN:
            break
    return _detect(rgb, scale, small, foreground)


def _keep_memory() -> None:
    """Keep the C library from giving memory back to the system while a picture is worked on.

    Fetching it again takes as long as the arithmetic does. glibc keeps as much as twice the
    greatest block that it mapped and freed (mallopt(3), M_MMAP_THRESHOLD); others do not mind.
    """
    block = np.empty(KEPT_BYTES // 2, np.uint8)
    del block


def _detect(rgb: Pixels, scale: int, small: Pixels, foreground: Foreground) -> Detection:
    """Find the cables, given the foreground of a picture made `scale` times smaller."""
    rough = rough_cables(small, foreground)
    if not rough:
        why = CLUTTERED if rough is None else NOTHING
        return Detection((), (), (*exposure_warnings(small), why))
    lines = [(r.line + 0.5) * scale - 0.5 for r in rough]
    refined = refine(rgb, lines, [r.width * scale for r in rough])
    candidates = [
        _Candidate(line, weigh(line, foreground.spread), ramp(r.margin, SURE_MARGIN))
        for r, line in zip(rough, refined, strict=True)
        if line is not None
    ]
    cables = []
    for found in _without_scraps(candidates):
        cable = _cable(rgb, found.line, found.confidence)
        cables.append(replace(cable, tips=_not_over(foreground.foreign_objects, cable, scale)))
    cables.sort(key=lambda c: -len(c.centreline))
    warnings = (
        *exposure_warnings(small),
        *cable_warnings(rgb, cables),
        *remainder_warnings(foreground, cables, scale),
    )
    return Detection(tuple(cables), find_crossings(rgb, cables), warnings)


@dataclass(frozen=True, eq=False)
class _Candidate:
    """What may be a cable: its centreline, what speaks for it, and how sure its joinings are."""

    line: Refined
    evidence: Evidence
    joined: float

    @property
    def confidence(self) -> float:
        """That it is one cable, and all of it."""
        return self.evidence.total * self.evidence.trust * self.joined


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


def _cable(rgb: Pixels, refined: Refined, confidence: float) -> DetectedCable:
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
        confidence=confidence,
    )
