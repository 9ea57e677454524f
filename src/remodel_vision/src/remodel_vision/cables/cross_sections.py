"""Cross-sections of cables, lines refined by them, and the confidence that follows.

Whether a line is a cable is decided by five factors, whose limits were read off some 600 true and
100 false centrelines in rendered scenes (benchmarks/vision): between the two lies a wide gap for
each of them. How sure it is that it is one cable and all of it, is a logistic model, fitted to true
and false answers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from remodel_vision.cables.confidence_weights import BIAS, WEIGHTS
from remodel_vision.cables.lines import (
    arc_lengths,
    limited,
    median,
    median_colour,
    normals,
    resample,
    smooth,
)
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# Samples of a profile, and how far it reaches [widths].
SAMPLES = 25
REACH = 1.2
OFFSETS = np.linspace(-REACH, REACH, SAMPLES).astype(np.float32)
MIDDLE = SAMPLES // 2
OUTWARD = OFFSETS[MIDDLE:]
STEP = REACH / MIDDLE
# Profiles averaged along the cable: noise falls, a bend within them does not matter.
ALONG = 3
# What of a profile shows the cable's body; its colour is learned from every third profile.
SPARSE = 3
BODY = slice(*np.searchsorted(OFFSETS, (-0.34, 0.34)).tolist())
# Edges are searched for from here on outwards.
EDGE_FROM = int(np.searchsorted(OUTWARD, 0.28))


def _means(offsets: Pixels, *ranges: tuple[float, float]) -> Pixels:
    """Return the matrix (m, k) that takes samples to their means over ranges of offsets."""
    inside = np.stack([(offsets > low) & (offsets < high) for low, high in ranges], axis=1)
    return (inside / inside.sum(axis=0)).astype(np.float32)


# Of a profile: the surroundings at its left and at its right end, and the cable's middle.
OF_SECTION = _means(OFFSETS, (-1.3, -1.0), (1.0, 1.3), (-0.18, 0.18))
# Of a side: its middle, just inside an edge, and near outside.
OF_SIDE = _means(OUTWARD, (-0.1, 0.18), (0.20, 0.34), (0.60, 0.80))
# A round cable's rim is as bright as this share of its middle (set on rendered tubes); at an edge
# one sees that share of the contrast, at least and at most.
RIM_SHADE = 0.65
AT_EDGE = (0.05, 0.55)
# What lies near outside differs from the middle by this share of what lies farther out, at least.
NEAR_SHARE = 0.5
# Colours are distinct in any shade when their directions differ by this sine, and when so much of
# the cable's is no shade of the surroundings' [grey levels].
DISTINCT_SINE, DISTINCT_LEVELS = 0.12, 30.0
# A side that is this share of the other, in the same hue, lies in the cable's shadow.
SHADOW = (0.35, 1.0)
# Hues are the same when that much of the difference of two colours is left without shades.
SAME_HUE = 0.3
# A camera's black: shades are compared as if each colour had a fourth channel of this level [grey
# levels]. So what noise shows on a black table has no hue and is no shade of a cable; on a lit
# table it changes nothing. Photographs on black do as well with 10 as with 80.
BLACK = 20.0


@dataclass(frozen=True, eq=False)
class CrossSections:
    """Edges along centrelines.

    Attributes:
        edges: (n, 2) offsets of the left and right edge from the centreline [px]; the left is
            negative; infinite where there is none.
        contrast: (n, 2) how far the colour just inside is from the surroundings [grey levels].
        middle: (n, 3) colour of the cable.
        inside: (n, 2, 3) the same just inside the left and the right edge.
        beside: (n, 2, 3) colour of the surroundings, left and right.
        shadow: (n,) how bright the darker side is, as a share of the other; 1 where that is no
            shadow of the same hue.
        softness: (n,) how far the blunter edge stretches [px].
    """

    edges: Pixels
    contrast: Pixels
    middle: Pixels
    inside: Pixels
    beside: Pixels
    shadow: Pixels
    softness: Pixels

    def part(self, of: slice) -> CrossSections:
        """Return some of the profiles."""
        return CrossSections(
            edges=self.edges[of],
            contrast=self.contrast[of],
            middle=self.middle[of],
            inside=self.inside[of],
            beside=self.beside[of],
            shadow=self.shadow[of],
            softness=self.softness[of],
        )


def find_edges(
    rgb: Pixels, points: Array, normals: Array, width: Array, counts: npt.NDArray[np.int_]
) -> CrossSections:
    """Return the edges on profiles.

    Args:
        rgb: (height, width, 3).
        points: (n, 2) on centrelines [px], cable after cable.
        normals: (n, 2) unit vectors.
        width: (n,) of the cable there [px].
        counts: (k,) of the points on each cable.
    """
    reach = width[:, None] * OFFSETS
    x = (points[:, :1] + reach * normals[:, :1]).astype(np.float32)
    y = (points[:, 1:] + reach * normals[:, 1:]).astype(np.float32)
    picked = cv2.remap(rgb, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    blurred = cv2.blur(picked.astype(np.float32), (1, ALONG), borderType=cv2.BORDER_REPLICATE)
    colours = np.stack(cv2.split(blurred))
    left, right, middle = (colours @ OF_SECTION).transpose(2, 0, 1)
    left, right, shadow = _lit(left, right)
    stops = np.cumsum(counts).tolist()
    bodies = [
        colours[:, i - n : i : SPARSE, BODY] for i, n in zip(stops, counts.tolist(), strict=True)
    ]
    own = np.stack([median_colour(body.reshape(3, -1).T) for body in bodies], axis=1)
    own = np.repeat(own, counts, axis=1)
    # Both sides of all profiles in a row: the left ones, then the right ones.
    sides = np.concatenate([colours[:, :, MIDDLE::-1], colours[:, :, MIDDLE:]], axis=1)
    around = np.concatenate([left, right], axis=1)
    middles, insides, near = (sides @ OF_SIDE).transpose(2, 0, 1)
    # Where the assumed width is too small, what should lie near outside is the cable itself.
    outside, far = middles - near, middles - around
    hidden = _dot(outside, outside) < NEAR_SHARE**2 * _dot(far, far)
    near = np.where(hidden, around, near)
    by_hue, distinct = _shares(sides, around, np.concatenate([own, own], axis=1))
    edge, last = _fall(np.where(distinct[:, None], by_hue, _levels(sides, middles, insides, near)))
    apart = insides - around
    contrast = np.sqrt(_dot(apart, apart))
    rows = np.arange(len(last))
    fall = sides[:, rows, last] - sides[:, rows, last + 1]
    slope = np.maximum(np.sqrt(_dot(fall, fall)), 1e-3)
    softness = (contrast / slope).reshape(2, -1).max(axis=0) * (STEP * width)
    half = len(points)
    return CrossSections(
        edges=np.stack([-width * edge[:half], width * edge[half:]], axis=1),
        contrast=contrast.reshape(2, -1).T,
        middle=middle.T,
        inside=insides.T.reshape(2, half, 3).transpose(1, 0, 2),
        beside=np.stack([left.T, right.T], axis=1),
        shadow=shadow,
        softness=softness,
    )


def _dot(a: Pixels, b: Pixels) -> Pixels:
    """Return the products of colours, whose channels come first."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def length(a: Pixels) -> Pixels:
    """Return the lengths of vectors (n, 3)."""
    return np.sqrt(_dot(a.T, a.T))


def _lit(left: Pixels, right: Pixels) -> tuple[Pixels, Pixels, Pixels]:
    """Return surroundings (3, n), the lit side for one in shadow, and how bright the shadow is."""
    left_lit = left.sum(axis=0) > right.sum(axis=0)
    light, dark = np.where(left_lit, left, right), np.where(left_lit, right, left)
    black = BLACK**2
    shade = limited((_dot(dark, light) + black) / (_dot(light, light) + black), *SHADOW)
    hue, whole = dark - shade * light, light - dark
    is_shadow = _dot(hue, hue) < SAME_HUE**2 * _dot(whole, whole)
    return (
        np.where(is_shadow & ~left_lit, light, left),
        np.where(is_shadow & left_lit, light, right),
        np.where(is_shadow, shade, 1.0),
    )


def _shares(colours: Pixels, beside: Pixels, own: Pixels) -> tuple[Pixels, npt.NDArray[np.bool_]]:
    """Return the cable's share of colours (3, n, m), and for which profiles (n,) it is reliable.

    A colour is taken for a s + b o with the surroundings s and the cable's own colour o (3, n); the
    share is b / (a + b), by least squares.
    """
    black = BLACK**2
    ss, oo = _dot(beside, beside) + black, _dot(own, own) + black
    so = _dot(beside, own) + black
    determinant = np.maximum(ss * oo - so**2, 1.0)
    distinct = determinant > np.maximum(DISTINCT_SINE**2 * oo, DISTINCT_LEVELS**2) * ss
    cs = _dot(colours, beside[:, :, None]) + black
    co = _dot(colours, own[:, :, None]) + black
    # The common factor 1 / determinant falls out of the share.
    a = np.maximum(oo[:, None] * cs - so[:, None] * co, 0.0)
    b = np.maximum(ss[:, None] * co - so[:, None] * cs, 0.0)
    return b / np.maximum(a + b, 1e-3), distinct


def _levels(colours: Pixels, middle: Pixels, inside: Pixels, outside: Pixels) -> Pixels:
    """Return the cable's share of colours (3, n, m), from the middle outwards, by their level.

    It is 1 where the colour is the cable's, in its middle or just inside the edge, whichever
    differs more (a dark cable's highlight differs less), a half at the edge, and 0 near outside.
    """
    middle, inside = middle - outside, inside - outside
    way = np.where(_dot(middle, middle) > _dot(inside, inside), middle, inside)
    whole = np.maximum(_dot(way, way), 1.0)
    rim = RIM_SHADE * (way + outside) - outside
    at_edge = limited(0.5 * _dot(rim, way) / whole, *AT_EDGE)
    # 0.5 + 0.5 (level - at_edge) / (1 - at_edge), with as little as possible done per sample.
    slope = 0.5 / (1 - at_edge)
    way = way * (slope / whole)
    return _dot(colours, way[:, :, None]) + (0.5 - slope * at_edge - _dot(outside, way))[:, None]


def _fall(share: Pixels) -> tuple[Pixels, npt.NDArray[np.intp]]:
    """Return where shares (n, m), from the middle outwards, fall below a half [widths].

    And the last samples before they do.
    """
    below = share[:, EDGE_FROM:] < 0.5
    first = np.argmax(below, axis=1)
    rows = np.arange(len(share))
    last = first + (EDGE_FROM - 1)
    before, after = share[rows, last], share[rows, last + 1]
    part = limited((before - 0.5) / np.maximum(before - after, 1e-3), 0, 1)
    return np.where(below[rows, first], OUTWARD[last] + part * STEP, np.inf), last


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
    same = _same_hue(sections.middle, own[None], contrast)
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
