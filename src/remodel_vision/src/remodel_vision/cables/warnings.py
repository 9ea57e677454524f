"""Where cables end, and warnings about a result."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from remodel_vision.cables.foreground import Foreground
from remodel_vision.cables.lines import (
    CableEnding,
    DetectedCable,
    Tip,
    arc_lengths,
    median,
    parabola,
)
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# The axis at an end is fitted to this part of the centreline, counted from the end: nearer to it
# a skeleton turns into a corner of the cut [widths].
AXIS_FROM, AXIS_TO = 0.9, 4.0
# Along the axis, looked at from this far inside the expected tip to this far beyond it [widths].
ALONG = np.linspace(-1.6, 1.4, 61)
# Samples well within the cable, and well beyond its tip.
WITHIN, OUTSIDE = slice(0, 20), slice(50, 61)
# A cable whose colour is so far from all shades of what lies beyond is recognised by that
# [grey levels].
OTHER_HUE = 18.0
# Lines beside the axis that are averaged [widths].
LINES = np.linspace(-0.24, 0.24, 5)
# How far the tip may lie from where the skeleton says: the standard deviation, and the most; beyond
# it a ferrule begins [widths].
TOLERANCE, FARTHEST = 0.5, 1.0
# A skeleton ends about this far before the tip [widths].
SKELETON_SHORT = 0.4
# Nearer to the border than this, a cable goes on beyond it [widths].
BORDER_WIDTHS = 0.8

# To see whether it goes on all the same: before and beyond its tip, across it and beside it
# [widths].
BEYOND = np.concatenate([np.linspace(-2.5, -1.0, 4), np.linspace(1.0, 2.5, 4)])
SIDEWAYS = np.array([-1.2, -1.05, -0.9, -0.2, -0.1, 0.0, 0.1, 0.2, 0.9, 1.05, 1.2])
MIDDLE = np.abs(SIDEWAYS) < 0.5
# Beyond true tips what lies there differs from its surroundings by up to 28, a ferrule by 31 and
# more [grey levels].
OTHER_COLOUR = 30.0
# To see whether its last bit is a shadow: before and beyond its tip [widths]; shades of the cable
# and of the table; a shadow is no shade of the cable by this [grey levels].
LAST = np.array([-1.0, -0.75, -0.5, 1.2, 1.6, 2.0])
OWN_SHADES, SHADOWS, NO_SHADE = (0.3, 1.6), (0.15, 0.95), 15.0


def find_end(rgb: Pixels, line: Array, width: float) -> Tip:
    """Return how a cable ends at the first point of its centreline (n, 2) [px], in even steps."""
    step = float(arc_lengths(line)[-1]) / (len(line) - 1)
    first = min(math.ceil(AXIS_FROM * width / step), len(line) - 2)
    count = max(math.floor(AXIS_TO * width / step), 8) + 1 - first
    part = line[first : first + count]
    # Where the axis would pass the end: a parabola, straight if it is short.
    fit = parabola(len(part), 2 if len(part) >= 6 else 1) @ part
    end = -first / (len(part) - 1)
    start, outward = fit[0] + end * fit[1], -fit[1]
    if len(fit) == 3:
        start, outward = start + end**2 * fit[2], outward - 2 * end * fit[2]
    outward = outward / math.hypot(*outward.tolist())
    limit = np.array([rgb.shape[1], rgb.shape[0]]) - 1.0
    rim = BORDER_WIDTHS * width
    if np.any(start < rim) or np.any(start > limit - rim):
        return Tip(_to_border(start, outward, limit), outward, CableEnding.TRUNCATED)
    return _find_tip(rgb, start + SKELETON_SHORT * width * outward, outward, width)


def _to_border(start: Array, outward: Array, limit: Array) -> Array:
    """Return where a ray from (2,) meets the border of a picture whose last pixel is (2,)."""
    with np.errstate(divide="ignore"):
        ways = np.where(outward > 0, (limit - start) / outward, -start / outward)
    way = float(np.min(ways[np.isfinite(ways)]))
    return np.clip(start + way * outward, 0, limit)


def _find_tip(rgb: Pixels, expected: Array, outward: Array, width: float) -> Tip:
    """Return the tip near an expected point (2,): where the colour changes fastest."""
    along = ALONG * width
    beside = np.array([-outward[1], outward[0]])
    places = expected + along[:, None] * outward + (LINES * width)[:, None, None] * beside
    x, y = cv2.split(places.astype(np.float32))
    colours = cv2.remap(rgb, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    mean = cv2.reduce(colours, 0, cv2.REDUCE_AVG, dtype=cv2.CV_32F)
    profile = cv2.blur(mean, (3, 1))[0]
    change = profile[2:] - profile[:-2]
    speed = np.sqrt(np.einsum("ij,ij->i", change, change))
    inner, outer = profile[WITHIN].mean(axis=0), profile[OUTSIDE].mean(axis=0)
    hue = inner - float(inner @ outer) / max(float(outer @ outer), 1.0) * outer
    strength = math.hypot(*hue.tolist())
    if strength > OTHER_HUE:
        # A shadow beyond the tip is no other hue.
        speed = np.abs(change @ (hue / strength))
    prior = np.exp(-0.5 * (along[1:-1] / (TOLERANCE * width)) ** 2)
    prior *= np.abs(along[1:-1]) <= FARTHEST * width
    best = min(max(int(np.argmax(speed * prior)), 1), len(speed) - 2)
    before, here, after = speed[best - 1 : best + 2].tolist()
    curve = before - 2 * here + after
    shift = min(max(0.5 * (before - after) / curve, -1.0), 1.0) if curve < 0 else 0.0
    place = along[best + 1] + shift * (along[1] - along[0])
    return Tip(expected + place * outward, outward, CableEnding.TIP)


def goes_on(rgb: Pixels, tip: Tip, width: float) -> float:
    """Return what share of a cable's contrast is left beyond its tip.

    Of another colour, as a ferrule's, only much counts. Pieces of the picture are averaged that are
    so large that noise does not matter.
    """
    beside = np.array([-tip.outward[1], tip.outward[0]])
    grid = (BEYOND * width)[:, None, None] * tip.outward + (SIDEWAYS * width)[:, None] * beside
    x, y = cv2.split((tip.point + grid).astype(np.float32))
    colours = cv2.remap(rgb, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    within, beyond = np.split(colours.astype(np.float64), 2)
    strip, table = within[:, MIDDLE].mean(axis=(0, 1)), within[:, ~MIDDLE].mean(axis=(0, 1))
    way = strip - table
    left = beyond[:, MIDDLE].mean(axis=(0, 1)) - beyond[:, ~MIDDLE].mean(axis=(0, 1))
    square = max(float(way @ way), 1.0)
    same, levels = float(left @ way) / square, math.hypot(*left.tolist())
    return max(same, levels / math.sqrt(square)) if levels > OTHER_COLOUR else same


def in_shadow(rgb: Pixels, tip: Tip, cable: DetectedCable) -> bool:
    """Return whether the last bit of a cable before a tip is a shadow on the table."""
    places = tip.point + (LAST * cable.width)[:, None] * tip.outward
    x, y = cv2.split(places.astype(np.float32)[None])
    colours = cv2.remap(rgb, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0]
    last, table = colours[:3].mean(axis=0), colours[3:].mean(axis=0)
    from_own = _from_shades(last, np.array(cable.colour), OWN_SHADES)
    return from_own > NO_SHADE and _from_shades(last, table, SHADOWS) < from_own / 2


def _from_shades(colour: Array, of: Array, shades: tuple[float, float]) -> float:
    """Return the distance of a colour (3,) from the shades of another [grey levels]."""
    shade = min(max(float(colour @ of) / max(float(of @ of), 1.0), shades[0]), shades[1])
    return math.dist(colour, shade * of)


NOTHING = "nothing in the picture looks like a cable"
CLUTTERED = "the picture is too cluttered; clear the table, or take it from nearer"
# A cable with less confidence causes a warning.
SURE = 0.5
# A picture is overexposed when this share of it is at the top of the scale, and dark when that
# share of it stays below a level.
CLIPPED, TOP = 0.18, 250
DARK_SHARE, DARK = 0.995, 75
# A tip beyond which this share of the contrast is left may be none: true ones leave up to 0.19,
# ends that noise cut 0.36 to 1.05.
GOES_ON = 0.28
# Evidence of which a cable has more only where it is hard to see: its width varies by this share,
# while so few of its edges agree; its edges stretch over this share of the width; this share of it
# lies beside a deep shadow.
UNEVEN, FEW_EDGES, BLURRED, IN_SHADOW = 0.06, 0.70, 0.8, 0.3
# Another way to join strands is nearly as good when it is dearer by less: right ones on photographs
# have 0.38 and more, wrong ones had 0.20 and 0.27.
AS_GOOD = 0.3
# A picture is noisy from this standard deviation on [grey levels].
NOISY = 17.0
# An end this near to another cable may be a part of it [widths].
BESIDE_WIDTHS = 1.7
# A line that leaves its chord by less is straight [widths].
STRAIGHT_WIDTHS = 0.5
# Farther than this from another cable an end may be at any distance [widths].
NEAR_WIDTHS = 6.0
# Two ends of like colours [grey levels], this near [widths], that face each other [cosine], may
# be one cable, with something hidden between them.
SAME_COLOUR, FACING_WIDTHS, FACING = 60.0, 12.0, 0.8
# Around a cable's width, shadow and blur explain so much more, to both sides together [widths],
# and [px of the mask].
RIM_WIDTHS, RIM_PX = 1.8, 3
# A rest counts from this area on [squared cable widths], where it is this far from the table's
# colour [standard deviations] and not at the rim of a foreign object.
REST = 4.0
CLEAR = 8.0
# A cable over a foreign object of another colour than the table causes a warning from this share of
# it on: a rim of the object may be taken for a cable, and a cable of its colour is not found.
OVER_FOREIGN_OBJECT = 0.02


@dataclass(frozen=True)
class Notice:
    """A reason why a result may be wrong, and the indices of the cables that it is about."""

    text: str
    cables: tuple[int, ...] = ()


def exposure_warnings(rgb: Pixels) -> Iterator[Notice]:
    """Yield what is wrong with the light of a picture (height, width, 3)."""
    red, green, blue = cv2.split(np.ascontiguousarray(rgb[::4, ::4]))
    brightest = cv2.max(cv2.max(red, green), blue)
    clipped = np.count_nonzero(brightest >= TOP) / brightest.size
    if clipped > CLIPPED:
        yield Notice(
            f"{clipped:.0%} of the picture is overexposed; take it with a shorter exposure"
        )
    steps = rgb[::12, :, 1].astype(np.int16)
    second = np.abs(steps[:, 2:] - 2 * steps[:, 1:-1] + steps[:, :-2])
    # Of Gaussian noise the second difference has the variance 6; the median is 0.674 deviations.
    noise = median(second) / (0.674 * math.sqrt(6))
    if noise > NOISY:
        yield Notice(f"the picture is noisy, by {noise:.0f} grey levels; take it with more light")
    if np.count_nonzero(brightest < DARK) > DARK_SHARE * brightest.size:
        yield Notice("the picture is dark; take it with more light or a longer exposure")


def cable_warnings(rgb: Pixels, cables: list[DetectedCable]) -> Iterator[Notice]:
    """Yield what is odd about cables in a picture (height, width, 3)."""
    if not cables:
        yield Notice(NOTHING)
    for i, cable in enumerate(cables):
        if cable.confidence < SURE:
            text = f"cable {i} may be none, or not one: confidence {cable.confidence:.2f}"
            yield Notice(text, (i,))
        if _is_ruled(cable):
            text = f"cable {i} is straight from border to border: it may be an edge or a seam"
            yield Notice(text, (i,))
        for tip in cable.tips:
            column, row = tip.point
            if tip.end is CableEnding.HIDDEN:
                yield Notice(
                    f"cable {i} may go on beyond ({column:.0f}, {row:.0f}), where a foreign object "
                    "lies",
                    (i,),
                )
            elif tip.end is CableEnding.TIP and in_shadow(rgb, tip, cable):
                text = f"cable {i} may end before ({column:.0f}, {row:.0f}): a shadow lies there"
                yield Notice(text, (i,))
            elif tip.end is CableEnding.TIP and goes_on(rgb, tip, cable.width) > GOES_ON:
                text = f"cable {i} may go on beyond ({column:.0f}, {row:.0f}), fainter"
                yield Notice(text, (i,))
            for j, other in enumerate(cables):
                gap = np.hypot(*(other.centreline - tip.point).T).min()
                if i != j and gap < BESIDE_WIDTHS * max(cable.width, other.width):
                    text = f"cable {i} ends at ({column:.0f}, {row:.0f}) on cable {j}"
                    yield Notice(text, (i, j))
    for (i, one), (j, other) in itertools.combinations(enumerate(cables), 2):
        if np.linalg.norm(np.subtract(one.colour, other.colour)) > SAME_COLOUR:
            continue
        for a, b in itertools.product(one.tips, other.tips):
            gap = b.point - a.point
            length = float(np.hypot(*gap))
            if length < FACING_WIDTHS * (one.width + other.width) / 2:
                facing = min(gap @ a.outward, -gap @ b.outward) / max(length, 1e-6)
                if facing > FACING:
                    text = f"cables {i} and {j} may be one: their ends face each other"
                    yield Notice(text, (i, j))


def evidence_warnings(terms: list[dict[str, float]]) -> Iterator[Notice]:
    """Yield what is odd about the evidence of cables, by the terms of their confidence."""
    for i, of in enumerate(terms):
        if of["softness [widths]"] > BLURRED:
            yield Notice(f"cable {i} is blurred; focus, or take it from nearer", (i,))
        if of["spread of the width"] > UNEVEN and of["edges that agree"] < FEW_EDGES:
            yield Notice(f"cable {i} varies in width: one of its edges may be another one", (i,))
        if of["margin"] < AS_GOOD:
            text = f"cable {i} may be joined to a part of another: another way is nearly as good"
            yield Notice(text, (i,))
        if of["deep shadows"] > IN_SHADOW:
            yield Notice(f"cable {i} lies beside a deep shadow; use softer light", (i,))


def _is_ruled(cable: DetectedCable) -> bool:
    """Return whether a cable enters and leaves the picture and is straight in between."""
    truncated = all(tip.end is CableEnding.TRUNCATED for tip in cable.tips)
    return truncated and _bend(cable) < STRAIGHT_WIDTHS


def _bend(cable: DetectedCable) -> float:
    """Return how far a cable leaves the chord between its tips [widths]."""
    chord = cable.tips[1].point - cable.tips[0].point
    away = (cable.centreline - cable.tips[0].point) @ np.array([-chord[1], chord[0]])
    return float(np.abs(away).max()) / (max(math.hypot(*chord.tolist()), 1.0) * cable.width)


def surrounding_terms(rgb: Pixels, cables: list[DetectedCable], index: int) -> dict[str, float]:
    """Return the terms of the confidence that the ends and the other cables give."""
    cable = cables[index]
    loose = [tip for tip in cable.tips if tip.end is CableEnding.TIP]
    left = [min(max(goes_on(rgb, tip, cable.width), -0.5), 1.5) for tip in loose]
    gaps = [
        float(np.hypot(*(other.centreline - tip.point).T).min()) / cable.width
        for tip in cable.tips
        for other in cables
        if other is not cable
    ]
    return {
        "goes on": max(left, default=0.0),
        "hidden ends": float(sum(tip.end is CableEnding.HIDDEN for tip in cable.tips)),
        "bend [log widths]": math.log(_bend(cable) + 0.1),
        "end near another [widths]": min(min(gaps, default=NEAR_WIDTHS), NEAR_WIDTHS),
    }


def remainder_warnings(
    foreground: Foreground, cables: list[DetectedCable], scale: int
) -> Iterator[Notice]:
    """Yield what is odd about cables in a mask made `scale` times smaller than the picture."""
    left = (foreground.distance > CLEAR).astype(np.uint8) & foreground.mask
    if foreground.foreign_objects.any():
        left[cv2.dilate(foreground.foreign_objects, np.ones((7, 7), np.uint8)) > 0] = 0
    for i, cable in enumerate(cables):
        line = (cable.centreline + 0.5) / scale - 0.5
        _wipe(left, line, cable.width / scale)
        share = over_foreign_objects(foreground, cable, scale)
        if share > OVER_FOREIGN_OBJECT:
            text = f"cable {i} lies on a foreign object for {share:.0%} of its length"
            yield Notice(text, (i,))
    if not cables:
        return
    typical = float(np.median([cable.width for cable in cables])) / scale
    if cv2.countNonZero(left) <= REST * typical**2:
        return
    count, _, stats, centres = cv2.connectedComponentsWithStats(left, connectivity=8)
    for label in range(1, count):
        if stats[label, cv2.CC_STAT_AREA] > REST * typical**2:
            column, row = (centres[label] + 0.5) * scale - 0.5
            yield Notice(f"what lies at ({column:.0f}, {row:.0f}) is part of no cable found")


def over_foreign_objects(foreground: Foreground, cable: DetectedCable, scale: int) -> float:
    """Return the share of a cable that lies on foreign objects."""
    objects = foreground.foreign_objects
    columns, rows = np.rint((cable.centreline + 0.5) / scale - 0.5).astype(int).T
    height, width = objects.shape
    at = objects[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    return float(at.mean())


def _wipe(mask: Pixels, line: Pixels, width: float) -> None:
    """Erase a centreline (n, 2) [px] with its surroundings, beyond its ends too."""
    start = line[0] + (line[0] - line[2]) / 2
    stop = line[-1] + (line[-1] - line[-3]) / 2
    fixed = np.rint(np.vstack([start, line, stop]) * 16).astype(np.int32)
    thickness = round(RIM_WIDTHS * width + RIM_PX)
    cv2.polylines(mask, [fixed], False, (0,), thickness, cv2.LINE_8, 4)
