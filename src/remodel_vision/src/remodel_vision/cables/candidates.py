"""What may be cables: centrelines of several foregrounds with their evidence, and a choice.

A cable is thin and has one colour. So it differs from the median over a few of its widths, whatever
lies there; and once a piece of it is known, the rest is what has that piece's colour and is thin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from remodel_vision.cables.cross_sections import Evidence, Refined, confidence, refine, weigh
from remodel_vision.cables.foreground import (
    DEVIATIONS,
    SPARSE,
    Foreground,
    Prior,
    above,
    distance_from,
    foreign_objects_in,
    majority,
    median_nearby,
    reach_in,
    typical_half_width,
    unlike_any_shade,
    whitening,
)
from remodel_vision.cables.joining import rough_cables
from remodel_vision.cables.lines import (
    CableEnding,
    DetectedCable,
    Tip,
    arc_lengths,
    fit,
    median_colour,
)
from remodel_vision.cables.warnings import (
    AXIS_FROM,
    SURE,
    find_end,
    over_foreign_objects,
    surrounding_terms,
)
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# Half widths of the cables that are searched for by their difference from what lies around [px].
HALF_WIDTHS = (1.5, 3.5)
# A cable's colours vary by this much at least [grey levels], and along its shades by this share.
COLOUR_FLOOR, SHADE_SHARE = 6.0, 0.12
# A pixel is of a colour up to so many standard deviations from it.
OF_COLOUR = 3.0


def local_foreground(rgb: Pixels, half_width: float, first: Foreground, prior: Prior) -> Foreground:
    """Return what differs from the median over a few widths around it.

    Args:
        rgb: (height, width, 3), some 320 columns.
        half_width: of the cables, roughly [px].
        first: the foreground by the table's colour.
        prior: what is known.
    """
    pixels = rgb.astype(np.float32)
    near = median_nearby(rgb, half_width)
    whiten, spread = whitening(pixels[1::SPARSE, 1::SPARSE] - near[1::SPARSE, 1::SPARSE])
    distance = distance_from(pixels, near, whiten)
    mask = majority(unlike_any_shade(pixels, near, whiten, distance))
    return _thin_parts(mask, spread, distance, _allowed(rgb, first, prior), first)


def colour_foreground(rgb: Pixels, samples: Array, first: Foreground, prior: Prior) -> Foreground:
    """Return what has the colour of samples (n, 3) [grey levels] of a piece of cable."""
    mean = samples.mean(axis=0)
    apart = samples - mean
    shade = SHADE_SHARE * mean
    spread = apart.T @ apart / len(samples) + COLOUR_FLOOR**2 * np.eye(3) + np.outer(shade, shade)
    values, vectors = np.linalg.eigh(spread)
    whiten = ((vectors / np.sqrt(values)).T).astype(np.float32)
    pixels = rgb.astype(np.float32)
    away = distance_from(pixels, np.broadcast_to(mean.astype(np.float32), pixels.shape), whiten)
    mask = majority((away < OF_COLOUR).astype(np.uint8))
    covered = np.where((mask | first.mask) > 0, 2 * DEVIATIONS, 0.0).astype(np.float32)
    return _thin_parts(mask, first.spread, covered, _allowed(rgb, first, prior), first)


def _allowed(rgb: Pixels, first: Foreground, prior: Prior) -> Pixels | None:
    """Return 1 where a cable may be seen; with a known background, where that is covered."""
    allowed = prior.allowed(rgb)
    if prior.background is None:
        return allowed
    covered = above(first.covered)
    return covered if allowed is None else allowed & covered


def _thin_parts(
    mask: Pixels, spread: float, covered: Pixels, allowed: Pixels | None, first: Foreground
) -> Foreground:
    """Return the parts of a mask that are thin enough for a cable."""
    if allowed is not None:
        mask = mask & allowed
    reach = reach_in(mask)
    half_width = typical_half_width(reach)
    thick = foreign_objects_in(reach, half_width)
    if thick.any():
        mask = np.where(thick > 0, 0, mask).astype(np.uint8)
        reach = reach_in(mask)
    return Foreground(
        mask=mask,
        reach=reach,
        foreign_objects=first.foreign_objects,
        half_width=half_width,
        spread=spread,
        covered=covered,
        distance=np.where(mask > 0, 2 * DEVIATIONS, 0.0).astype(np.float32),
    )


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
# Colours of so many pieces are searched for; two are the same up to so many grey levels.
MOST_COLOURS, SAME_COLOUR = 6, 30.0
# Of two candidates that share more than this share of one, the likelier is taken.
SHARED = 0.4


@dataclass(frozen=True, eq=False)
class Candidate:
    """What may be a cable.

    Attributes:
        line: its centreline and cross-section profiles.
        evidence: what speaks for it.
        margin: how sure its joinings are.
        cable: as it would be reported.
    """

    line: Refined
    evidence: Evidence
    margin: float
    cable: DetectedCable


def first_candidates(
    rgb: Pixels, scale: int, small: Pixels, foreground: Foreground, prior: Prior
) -> list[Candidate] | None:
    """Return the candidates in one foreground; None where it is in too many pieces.

    Args:
        rgb: (height, width, 3).
        scale: how much smaller the small picture is.
        small: the small picture.
        foreground: of the small picture.
        prior: what is known.
    """
    found = _candidates(rgb, scale, small, foreground, prior)
    return found if found is None else _without_scraps(found)


def _candidates(
    rgb: Pixels, scale: int, small: Pixels, foreground: Foreground, prior: Prior
) -> list[Candidate] | None:
    rough = rough_cables(small, foreground)
    if rough is None:
        return None
    if not rough:
        return []
    lines = [(r.line + 0.5) * scale - 0.5 for r in rough]
    refined = refine(rgb, lines, [r.width * scale for r in rough])
    return [
        Candidate(
            line,
            weigh(line, foreground.spread),
            min(r.margin, SURE_MARGIN),
            _cable(rgb, line, foreground, scale),
        )
        for r, line in zip(rough, refined, strict=True)
        if line is not None and prior.fits(line.width)
    ]


def more_candidates(
    rgb: Pixels,
    scale: int,
    small: Pixels,
    foreground: Foreground,
    prior: Prior,
    first: list[Candidate],
) -> list[Candidate]:
    """Return the first candidates, and those of other foregrounds of a cluttered picture."""
    coarse = prior.smaller(scale)
    pool = list(first)
    half_widths = {width / 2 for width in coarse.widths} or HALF_WIDTHS
    for half_width in sorted(half_widths):
        local = local_foreground(small, half_width, foreground, coarse)
        pool += _candidates(rgb, scale, small, local, prior) or []
    for samples in [] if prior.is_specific else _colours(pool):
        coloured = colour_foreground(small, samples, foreground, coarse)
        pool += _candidates(rgb, scale, small, coloured, prior) or []
    if prior.is_specific:
        pool = [c for c in pool if c.evidence.total >= NO_CABLE]
        ranks = [c.evidence.total * len(c.line.points) for c in pool]
    else:
        pool = [c for c in pool if c.evidence.edges > 0 and c.evidence.length > 0]
        ranks = [rate(rgb, [c], 0, foreground, scale) for c in pool]
    return _best(pool, ranks, foreground, scale)


def _colours(pool: list[Candidate]) -> list[Array]:
    """Return samples (n, 3) of the colours of the likeliest pieces of cables."""
    chosen: list[Array] = []
    ranked = sorted(
        pool,
        key=lambda c: -c.evidence.edges * c.evidence.even * len(c.line.points),
    )
    for candidate in ranked:
        samples = candidate.line.sections.middle
        middle = median_colour(samples)
        if all(np.linalg.norm(middle - median_colour(other)) > SAME_COLOUR for other in chosen):
            chosen.append(samples)
        if len(chosen) == MOST_COLOURS:
            break
    return chosen


def _best(
    pool: list[Candidate], ranks: list[float], foreground: Foreground, scale: int
) -> list[Candidate]:
    """Return the highest ranked of candidates that lie on each other."""
    taken: Pixels = np.zeros(foreground.mask.shape, np.uint8)
    kept = []
    for i in sorted(range(len(pool)), key=lambda i: -ranks[i]):
        cable = pool[i].cable
        line = (cable.centreline + 0.5) / scale - 0.5
        columns, rows = np.rint(line).astype(int).T
        height, width = taken.shape
        on = taken[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
        if on.mean() > SHARED:
            continue
        fixed = np.rint(line * 16).astype(np.int32)
        thickness = max(1, round(cable.width / scale + 1))
        cv2.polylines(taken, [fixed], False, (1,), thickness, cv2.LINE_8, 4)
        kept.append(pool[i])
    return kept


def rate(
    rgb: Pixels, candidates: list[Candidate], index: int, foreground: Foreground, scale: int
) -> float:
    """Return the confidence in one of some candidates, which all would be reported."""
    return confidence(terms_of(rgb, candidates, index, foreground, scale))


def terms_of(
    rgb: Pixels, candidates: list[Candidate], index: int, foreground: Foreground, scale: int
) -> dict[str, float]:
    """Return the terms of the confidence of one of some candidates."""
    candidate = candidates[index]
    return {
        **candidate.evidence.terms,
        "margin": candidate.margin,
        "foreground [log share]": math.log(float(foreground.mask.mean()) + 0.01),
        "over foreign objects": over_foreign_objects(foreground, candidate.cable, scale),
        **surrounding_terms(rgb, [c.cable for c in candidates], index),
    }


def _without_scraps(candidates: list[Candidate]) -> list[Candidate]:
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


def _cable(rgb: Pixels, refined: Refined, foreground: Foreground, scale: int) -> DetectedCable:
    """Find the ends and fit the spline; the confidence is not known yet."""
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
    objects = foreground.foreign_objects
    return DetectedCable(
        centreline=line,
        spline=spline,
        tips=(_hidden(first, objects, width, scale), _hidden(last, objects, width, scale)),
        width=width,
        colour=(red, green, blue),
        confidence=0.0,
    )


def _hidden(tip: Tip, foreign_objects: Pixels, width: float, scale: int) -> Tip:
    """Return a tip; one at the edge of a foreign object is hidden."""
    beyond = (tip.point + (width + scale) * tip.outward + 0.5) / scale - 0.5
    column, row = np.clip(np.rint(beyond).astype(int), 0, np.array(foreign_objects.shape[::-1]) - 1)
    hidden = tip.end is CableEnding.TIP and foreign_objects[row, column]
    return replace(tip, end=CableEnding.HIDDEN) if hidden else tip
