"""Find where cables end: at tips, or at the border of the picture."""

from __future__ import annotations

import math

import cv2
import numpy as np

from remodel_vision.cables.lines import arc_lengths, parabola
from remodel_vision.cables.model import CableEnding, DetectedCable, Tip
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
