"""Find cables' two edges on ribs across them, to a fraction of a pixel.

A rib is a row of samples across a centreline. Each sample is a mixture of the cable's colour and of
the surroundings' on its side; an edge is where, on the way out, the cable's share falls below a
half. Where the two colours differ in more than brightness, the shares are those of any shades of
the two, so that neither the cable's dark side nor a shadow beside it moves the edge; otherwise the
edge is where the distance from the surroundings falls fastest. All ribs of all cables are worked on
at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from remodel_sim.core.geometry import Array
from remodel_sim.core.vision.cables.robust import limited, median_colour
from remodel_sim.core.vision.pixels import Pixels

# Samples of a rib, and how far it reaches [widths].
SAMPLES = 33
REACH = 1.2
OFFSETS = np.linspace(-REACH, REACH, SAMPLES).astype(np.float32)
MIDDLE = SAMPLES // 2
OUTWARD = OFFSETS[MIDDLE:]
# Ribs averaged along the cable: noise falls, a bend within them does not matter.
ALONG = 3
# Samples at each end of a rib that show the surroundings.
OUTER = 3
# Samples of the cable's middle, of its body, and just inside an edge, on the way out.
CORE = np.abs(OFFSETS) < 0.18
BODY = np.abs(OFFSETS) < 0.34
RIM = (OUTWARD > 0.20) & (OUTWARD < 0.34)
# Edges are looked for from here on outwards [widths].
EDGE_FROM = 0.28
EDGE_TO = 0.95
# The steepest fall over two samples is an edge from this share of the contrast on.
LEAST_FALL = 0.12
# Colours whose directions differ by this sine are told apart in any shade.
TOLD_APART = 0.12
# A side that is this share of the other, in the same hue, lies in the cable's shadow.
SHADOW = (0.35, 1.0)
# Hues are the same when that much of the difference of two colours is left without shades.
SAME_HUE = 0.3


@dataclass(frozen=True, eq=False)
class Ribs:
    """Edges along centrelines.

    Attributes:
        edges: (n, 2) offsets of the left and right edge from the centreline [px]; the left is
            negative; infinite where there is none.
        contrast: (n, 2) how far the colour just inside is from the surroundings [grey levels].
        middle: (n, 3) colour of the cable.
        beside: (n, 2, 3) colour of the surroundings, left and right.
        shadow: (n,) how bright the darker side is, as a share of the other; 1 where that is no
            shadow of the same hue.
        softness: (n,) how far the blunter edge stretches [px].
    """

    edges: Pixels
    contrast: Pixels
    middle: Pixels
    beside: Pixels
    shadow: Pixels
    softness: Pixels

    def part(self, of: slice) -> Ribs:
        """Return some of the ribs."""
        return Ribs(
            self.edges[of],
            self.contrast[of],
            self.middle[of],
            self.beside[of],
            self.shadow[of],
            self.softness[of],
        )


def find_edges(rgb: Pixels, points: Array, normals: Array, width: Array, cable: Array) -> Ribs:
    """Return the edges on ribs.

    Args:
        rgb: (height, width, 3).
        points: (n, 2) on centrelines [px].
        normals: (n, 2) unit vectors.
        width: (n,) of the cable there [px].
        cable: (n,) the number of the cable, from 0 on without gaps.
    """
    reach = width[:, None] * OFFSETS
    x = (points[:, :1] + reach * normals[:, :1]).astype(np.float32)
    y = (points[:, 1:] + reach * normals[:, 1:]).astype(np.float32)
    picked = cv2.remap(rgb, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    blurred = cv2.blur(picked.astype(np.float32), (1, ALONG), borderType=cv2.BORDER_REPLICATE)
    colours = np.stack(cv2.split(blurred))
    *beside, shadow = _lit(_mean(colours[:, :, :OUTER]), _mean(colours[:, :, -OUTER:]))
    body = colours[:, :, BODY]
    starts = np.flatnonzero(np.diff(cable, prepend=-1))
    own = np.stack(
        [
            median_colour(body[:, start:stop].reshape(3, -1).T)
            for start, stop in zip(starts, [*starts[1:], len(cable)], strict=True)
        ]
    )[cable].T
    edges, contrasts, softness = [], [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        outward = colours[:, :, MIDDLE::-1] if side == 0 else colours[:, :, MIDDLE:]
        apart = outward - beside[side][:, :, None]
        distance = np.sqrt(_dot(apart, apart))
        rim = distance[:, RIM].mean(axis=1)
        by_hue, told = _shares(outward, beside[side], own)
        steepest, slope = _steepest_fall(distance, rim)
        edge = np.where(told, _fall(by_hue), steepest)
        softness.append(rim / np.maximum(slope, 1e-3) * width)
        edges.append(sign * width * edge)
        contrasts.append(rim)
    middle = _mean(colours[:, :, CORE]).T
    around = np.stack([side.T for side in beside], axis=1)
    return Ribs(
        np.stack(edges, axis=1),
        np.stack(contrasts, axis=1),
        middle,
        around,
        shadow,
        np.maximum(*softness),
    )


def _mean(colours: Pixels) -> Pixels:
    return colours.mean(axis=2)


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
    shade = limited(_dot(dark, light) / np.maximum(_dot(light, light), 1.0), *SHADOW)
    hue, whole = dark - shade * light, light - dark
    is_shadow = _dot(hue, hue) < SAME_HUE**2 * _dot(whole, whole)
    return (
        np.where(is_shadow & ~left_lit, light, left),
        np.where(is_shadow & left_lit, light, right),
        np.where(is_shadow, shade, 1.0),
    )


def _shares(colours: Pixels, beside: Pixels, own: Pixels) -> tuple[Pixels, npt.NDArray[np.bool_]]:
    """Return the cable's share of colours (3, n, m), and for which ribs (n,) it is to be trusted.

    A colour is taken for a s + b o with the surroundings s and the cable's own colour o (3, n); the
    share is b / (a + b), by least squares.
    """
    ss, oo, so = _dot(beside, beside) + 1.0, _dot(own, own) + 1.0, _dot(beside, own)
    determinant = np.maximum(ss * oo - so**2, 1.0)
    told = determinant > TOLD_APART**2 * ss * oo
    cs = _dot(colours, beside[:, :, None])
    co = _dot(colours, own[:, :, None])
    # The common factor 1 / determinant falls out of the share.
    a = np.maximum(oo[:, None] * cs - so[:, None] * co, 0.0)
    b = np.maximum(ss[:, None] * co - so[:, None] * cs, 0.0)
    return b / np.maximum(a + b, 1e-3), told


def _fall(share: Pixels) -> Pixels:
    """Return where shares (n, m), from the middle outwards, fall below a half [widths]."""
    start = int(np.searchsorted(OUTWARD, EDGE_FROM))
    below = share[:, start:] < 0.5
    first = np.argmax(below, axis=1)
    rows = np.arange(len(share))
    found = below[rows, first]
    k = first + start
    before, after = share[rows, k - 1], share[rows, k]
    part = (before - 0.5) / np.maximum(before - after, 1e-3)
    edge = OUTWARD[k - 1] + limited(part, 0, 1) * (OUTWARD[1] - OUTWARD[0])
    return np.where(found, edge, np.inf)


def _steepest_fall(distance: Pixels, rim: Pixels) -> tuple[Pixels, Pixels]:
    """Return where distances (n, m), outwards, fall fastest [widths], and how fast [1/width]."""
    start, stop = np.searchsorted(OUTWARD, (EDGE_FROM, EDGE_TO))
    slope = distance[:, start - 1 : stop - 1] - distance[:, start + 1 : stop + 1]
    rows = np.arange(len(slope))
    best = limited(np.argmax(slope, axis=1), 1, slope.shape[1] - 2)
    before, here, after = slope[rows, best - 1], slope[rows, best], slope[rows, best + 1]
    curve = np.minimum(before - 2 * here + after, -1e-6)
    shift = limited(0.5 * (before - after) / curve, -1, 1)
    edge = OUTWARD[best + start] + shift * (OUTWARD[1] - OUTWARD[0])
    per_width = 0.5 * here / (OUTWARD[1] - OUTWARD[0])
    return np.where(here > LEAST_FALL * rim, edge, np.inf), per_width
