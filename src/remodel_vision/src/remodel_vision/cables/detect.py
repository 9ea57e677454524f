"""Find all cables in a picture, where they cross, and which lies on top.

Each strand has an appearance before and after the crossing: its colour, and across it its lit side,
its dark side and its highlight. The crossing shows the appearance of the upper one.

A mask at low resolution says where the table is covered; its skeleton is cut into strands where
they meet; strands are joined to cables; edges at full resolution give centrelines, widths and tips
to a fraction of a pixel. What is not certain causes a warning.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from remodel_vision.cables.candidates import Candidate, first_candidates, more_candidates, rate
from remodel_vision.cables.foreground import Foreground, Prior, checked_prior, find_foreground
from remodel_vision.cables.lines import Crossing, DetectedCable, Detection, limited
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
