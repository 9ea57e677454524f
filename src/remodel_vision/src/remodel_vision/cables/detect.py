"""Find all cables in a picture.

A mask at low resolution says where the table is covered; its skeleton is cut into strands where
they meet; strands are joined to cables; edges at full resolution give centrelines, widths and tips
to a fraction of a pixel. What is not certain causes a warning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from remodel_vision.cables.candidates import (
    Candidate,
    first_candidates,
    more_candidates,
    rate,
)
from remodel_vision.cables.crossings import find_crossings
from remodel_vision.cables.model import (
    Crossing,
    DetectedCable,
    Detection,
)
from remodel_vision.cables.strands.foreground import (
    Foreground,
    Prior,
    checked_prior,
    find_foreground,
)
from remodel_vision.cables.warnings import (
    CLUTTERED,
    NOTHING,
    Notice,
    cable_warnings,
    evidence_warnings,
    exposure_warnings,
    remainder_warnings,
)
from remodel_vision.colour import Pixels

# The foreground is found in a picture of about so many columns; in the finer one where cables are
# this thin in the first [px].
WORKING_COLUMNS = (320, 640)
THIN = 1.0
MIN_SIDE = 64
KEPT_BYTES = 8_000_000
# Where widths are known the narrowest cable is so wide in that picture [px].
KNOWN_PX = 4.0
# Lines with less confidence are not reported, unless colours and widths are known.
LEAST = 0.02


def detect_cables(
    rgb: Pixels,
    mask: Pixels | None = None,
    colours: Sequence[Sequence[float]] = (),
    widths: Sequence[float] = (),
    background: Pixels | None = None,
) -> Detection:
    """Find the cables in a picture (height, width, 3), RGB.

    With colours and widths every line that fits them is returned, however low its confidence: a
    caller that knows the scene can put pieces together.

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
        if widths:
            scale = max(1, min(scale, int(min(widths) / KNOWN_PX)))
        small = cv2.resize(rgb, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)
        foreground = find_foreground(small, prior.smaller(scale))
        if scale == 1 or widths or foreground.half_width > THIN:
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
    lit = list(exposure_warnings(rgb))
    first = first_candidates(rgb, scale, small, foreground, prior)
    least = 0.0 if prior.is_specific else LEAST
    cables, notices = _judged(rgb, first or [], foreground, scale, least=least)
    if notices:
        found = more_candidates(rgb, scale, small, foreground, prior, first or [])
        cables, notices = _judged(rgb, found, foreground, scale, least=least)
    if first is None:
        notices = [Notice(CLUTTERED), *(n for n in notices if n.text != NOTHING)]
    return _detection(cables, find_crossings(rgb, cables), [*lit, *notices])


def _judged(
    rgb: Pixels, candidates: list[Candidate], foreground: Foreground, scale: int, least: float
) -> tuple[list[DetectedCable], list[Notice]]:
    """Return the candidates of some confidence at least, the longest first, and the warnings."""
    ordered = sorted(candidates, key=lambda c: -len(c.line.points))
    rated = [
        (replace(candidate.cable, confidence=rate(rgb, ordered, i, foreground, scale)), candidate)
        for i, candidate in enumerate(ordered)
    ]
    likely = [(cable, candidate) for cable, candidate in rated if cable.confidence >= least]
    cables = [cable for cable, _ in likely]
    notices = [
        *cable_warnings(rgb, cables),
        *evidence_warnings([{**c.evidence.terms, "margin": c.margin} for _, c in likely]),
        *remainder_warnings(foreground, cables, scale),
    ]
    left_out = len(rated) - len(cables)
    if left_out:
        notices.append(Notice(f"lines left out, with a confidence below {least}: {left_out}"))
    return cables, notices


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
