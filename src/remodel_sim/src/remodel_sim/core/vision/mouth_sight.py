"""Tell from a picture what is before the mouth of a terminal.

The strip of the picture that the bore's axis crosses just outside the mouth is unrolled: one row
for each distance from the face, one column for each place across. What lies behind looks alike all
along a row, so a row's two flanks tell what its middle would look like if nothing were there. Rows
that look so show an empty axis. Rows whose middle differs show something thin, which has a colour,
a middle line and, when it is an end that is not pushed in, a ferrule.

One picture that shows the axis empty proves that nothing sits in the mouth. That something sits
there takes two pictures from places apart: what passes above or below the axis lies beside it in
one of them. A picture with depth tells by itself how high a thing is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np
import numpy.typing as npt

from remodel_sim.core.camera import Picture
from remodel_sim.core.component_shape import LABEL_CELLS, label_corners
from remodel_sim.core.geometry import Array, Pose
from remodel_sim.core.panel import Component, Wire
from remodel_sim.core.vision.colour import WIRE_SHADES, ferrule_mask, shade_distance
from remodel_sim.core.wire_colours import GREEN_AND_YELLOW, WIRE_RGB

# The strip: distances from the face along the axis, and places across it [m].
STEP_M = 0.00025
REACH_M = 0.014
HALF_WIDTH_M = 0.0075
# What is nearer to the face than the first is mixed with the funnel's rim; within the second a
# wire is as straight as its bore [m].
RIM_M, STRAIGHT_M = 0.0020, 0.0080
# Where across a row its flanks are, in diameters from the axis: a neighbour is 12 mm away.
FLANK_DIAMETERS = (1.15, 1.75)
# A thing shows within so many diameters of the axis.
SHOWN_DIAMETERS = 0.9
# Differences from the flanks: noise stays below the first, a white wire on white is above the
# second [grey levels].
NOISE_LEVELS, SHOWN_LEVELS = 12.0, 16.0
# Share of the rows that must show it: a white wire looks like the plate where its shade is right.
MOST = 0.75
# A seated wire's middle line is so near to the axis [m], and leaves it by no more than so much per
# length.
ASIDE_M = 0.0014
LEAVING = 0.45
# A ferrule that shows by more than the first is not pushed in to the bottom; by less than the
# second it is [m].
PUSHED_OUT_M, PUSHED_IN_M = 0.0045, 0.0032
# A wire's colour is the one asked for when no other is nearer by this much; it is another one when
# one is nearer by more than the second [grey levels].
SAME_LEVELS, OTHER_LEVELS = 6.0, 20.0
# Its distance from that colour is at most this [grey levels].
FAR_LEVELS = 60.0
# A label's white under the cell's usual light, and where it is too dark or too bright to be the
# measure of other colours [grey levels].
WHITE_LEVEL, DARK_LEVEL, FULL_LEVEL = 246.0, 60.0, 254.0
# Heights by depth may err by this much [m].
HEIGHT_M = 0.005
# Share of a row's middle that is a ferrule's colour where one shows.
LEAST_FERRULE = 0.25
# The colour is taken from the middle of the wire, clear of the ferrule, from so many samples.
CORE_DIAMETERS, CLEAR_OF_FERRULE_M, LEAST_SAMPLES = 0.35, 0.0008, 20

Mask = npt.NDArray[np.bool_]


class Sight(Enum):
    """What a picture shows before a mouth."""

    WIRE = "a wire of that colour goes into the mouth"
    OTHER_WIRE = "a wire of another colour goes into the mouth"
    LOOSE_END = "an end lies before the mouth"
    EMPTY = "nothing is before the mouth"
    UNCLEAR = "it is not seen what is before the mouth"


@dataclass(frozen=True)
class MouthSight:
    """One picture's answer.

    Attributes:
        sight: what it shows.
        proven: whether a single picture is enough for that: nothing was seen, or its height too.
    """

    sight: Sight
    proven: bool


def settle(sights: Sequence[MouthSight]) -> Sight:
    """Return what several pictures show together; UNCLEAR as long as they do not prove it."""
    if any(seen.sight is Sight.EMPTY for seen in sights):
        return Sight.EMPTY
    clear = [seen for seen in sights if seen.sight is not Sight.UNCLEAR]
    kinds = {seen.sight for seen in clear}
    if len(kinds) == 1 and (len(clear) > 1 or clear[0].proven):
        return clear[0].sight
    return Sight.UNCLEAR


@dataclass(frozen=True, eq=False)
class Strip:
    """The unrolled picture before a mouth.

    Attributes:
        along: (n,) distance of each row from the face [m].
        across: (m,) place of each column beside the axis [m].
        rgb: (n, m, 3) grey levels.
        height: (n, m) of what is seen above the plate [m]; None without depth.
    """

    along: Array
    across: Array
    rgb: Array
    height: Array | None


def unroll(picture: Picture, world_from_socket: Pose) -> Strip | None:
    """Return the strip before a mouth; None when it is not wholly in the picture."""
    along = np.arange(0.0, REACH_M, STEP_M)
    across = np.arange(-HALF_WIDTH_M, HALF_WIDTH_M + STEP_M / 2, STEP_M)
    grid = np.stack(np.meshgrid(-along, across, indexing="ij"), axis=-1).reshape(-1, 2)
    points = world_from_socket.apply(np.column_stack([grid, np.zeros(len(grid))]))
    if not picture.view.sees(points, 1.0):
        return None
    pixels = picture.view.project(points)
    shape = len(along), len(across)
    smooth = cv2.GaussianBlur(picture.rgb, (0, 0), 0.7)
    rgb = _sampled(smooth, pixels).reshape(*shape, 3)
    if picture.depth is None:
        return Strip(along, across, rgb, None)
    depths = _sampled(picture.depth.astype(np.float32), pixels)
    height = picture.view.at_depth(pixels, depths)[:, 2].reshape(shape)
    return Strip(along, across, rgb, height)


def white_level(picture: Picture, component: Component, pose: Pose) -> float:
    """Return how bright the margin of a component's label is, the light's measure."""
    corners = label_corners(component)
    middle = corners.mean(axis=0)
    rim = middle + (corners - middle) * (1 + 1 / LABEL_CELLS)
    share = np.linspace(0, 1, 25)[:, None]
    sides = [a + share * (b - a) for a, b in zip(rim, np.roll(rim, -1, axis=0), strict=True)]
    pixels = picture.view.project(pose.apply(np.vstack(sides)))
    levels = _sampled(picture.rgb, pixels)
    return float(np.median(levels.mean(axis=-1)))


def look_at_mouth(
    picture: Picture, world_from_socket: Pose, wire: Wire, white: float
) -> MouthSight:
    """Return what a picture shows before a mouth.

    Args:
        picture: of it.
        world_from_socket: the mouth's frame, x into the bore, by the component's label.
        wire: whose end is asked for.
        white: how bright a white label is there [grey levels].
    """
    strip = unroll(picture, world_from_socket)
    if strip is None:
        return MouthSight(Sight.UNCLEAR, False)
    rows = (strip.along >= RIM_M) & (strip.along <= STRAIGHT_M)
    differs = _difference(strip, wire.diameter)
    near = np.abs(strip.across) <= SHOWN_DIAMETERS * wire.diameter
    shown = np.sort(differs[:, near], axis=1)[:, -round(0.4 * near.sum()) :].mean(axis=1)
    # What lies across the axis covers some of it; a wire that goes on behind it shows beyond.
    goes_on = np.mean(shown[strip.along > STRAIGHT_M] > SHOWN_LEVELS) >= MOST
    if np.all(shown[rows] < NOISE_LEVELS) and not goes_on:
        return _empty(strip, rows, near, world_from_socket)
    if np.mean(shown[rows] > SHOWN_LEVELS) < MOST:
        return MouthSight(Sight.UNCLEAR, False)
    ferrule = _ferrule_length(strip, near)
    if ferrule > PUSHED_OUT_M:
        return _at_height(Sight.LOOSE_END, strip, rows, near, world_from_socket, wire)
    if ferrule > PUSHED_IN_M or not _on_axis(strip, differs, rows, near):
        return MouthSight(Sight.UNCLEAR, False)
    sight = _whose(strip, differs, rows, near, ferrule, wire, white)
    return _at_height(sight, strip, rows, near, world_from_socket, wire)


def _sampled(image: npt.NDArray[np.generic], pixels: Array) -> Array:
    at = pixels.astype(np.float32)
    values = cv2.remap(image, at[None, :, 0], at[None, :, 1], cv2.INTER_LINEAR)[0]
    return np.asarray(values, np.float64)


def _difference(strip: Strip, diameter: float) -> Array:
    """Return how far each place is from what its row's flanks show, (n, m) [grey levels]."""
    low, high = (d * diameter for d in FLANK_DIAMETERS)
    left = strip.rgb[:, (strip.across < -low) & (strip.across > -high)].mean(axis=1)
    right = strip.rgb[:, (strip.across > low) & (strip.across < high)].mean(axis=1)
    # The flank that is more alike: a neighbour's wire may lie over the other.
    beside = [np.linalg.norm(strip.rgb - flank[:, None], axis=-1) for flank in (left, right)]
    return np.minimum(*beside)


def _empty(strip: Strip, rows: Mask, near: Mask, world_from_socket: Pose) -> MouthSight:
    """Return EMPTY, or UNCLEAR when something wide hides the strip."""
    if strip.height is None:
        return MouthSight(Sight.EMPTY, True)
    highest = float(np.quantile(strip.height[rows][:, near], 0.9))
    low = highest < float(world_from_socket.position[2]) - HEIGHT_M
    return MouthSight(Sight.EMPTY if low else Sight.UNCLEAR, low)


def _ferrule_length(strip: Strip, near: Mask) -> float:
    """Return how far from the face a ferrule shows [m]; 0 when none does."""
    levels = np.clip(np.rint(strip.rgb), 0, 255).astype(np.uint8)
    share = ferrule_mask(levels)[:, near].mean(axis=1)
    seen = np.flatnonzero(share > LEAST_FERRULE)
    return float(strip.along[seen[-1]]) if len(seen) else 0.0


def _on_axis(strip: Strip, differs: Array, rows: Mask, near: Mask) -> bool:
    """Return whether the middle line of what shows leads out of the mouth."""
    weights = np.clip(differs[rows][:, near] - NOISE_LEVELS, 0.0, None)
    middles = weights @ strip.across[near] / np.maximum(weights.sum(axis=1), 1e-9)
    slope, offset = np.polyfit(strip.along[rows], middles, 1)
    at_face = offset + slope * RIM_M
    return bool(abs(at_face) < ASIDE_M and abs(slope) < LEAVING)


def _whose(
    strip: Strip,
    differs: Array,
    rows: Mask,
    near: Mask,
    ferrule: float,
    wire: Wire,
    white: float,
) -> Sight:
    """Return whether what goes into the mouth has the colour of the wire asked for."""
    beyond = rows & (strip.along > ferrule + CLEAR_OF_FERRULE_M)
    core = near & (np.abs(strip.across) < CORE_DIAMETERS * wire.diameter)
    shown = differs[beyond][:, core] > SHOWN_LEVELS
    if not DARK_LEVEL < white < FULL_LEVEL or shown.sum() < LEAST_SAMPLES:
        return Sight.UNCLEAR
    gain = WHITE_LEVEL / min(white, WHITE_LEVEL)
    pixels = (gain * strip.rgb[beyond][:, core][shown]).astype(np.float32)
    away = {code: _away(pixels, code) for code in WIRE_RGB}
    own = away.pop(wire.colour)
    nearest = min(away.values())
    if own < FAR_LEVELS and own < nearest + SAME_LEVELS:
        return Sight.WIRE
    return Sight.OTHER_WIRE if own > nearest + OTHER_LEVELS else Sight.UNCLEAR


def _away(pixels: npt.NDArray[np.float32], colour: str) -> float:
    """Return the median distance of pixels (n, 3) from the shades of a wire [grey levels]."""
    colours = GREEN_AND_YELLOW if colour == "GNYE" else (WIRE_RGB[colour],)
    return float(np.median(np.min([shade_distance(pixels, c, WIRE_SHADES) for c in colours], 0)))


def _at_height(
    sight: Sight, strip: Strip, rows: Mask, near: Mask, world_from_socket: Pose, wire: Wire
) -> MouthSight:
    """Return what is seen, proven when it is as high as the mouth, UNCLEAR when it is not."""
    if strip.height is None or sight is Sight.UNCLEAR:
        return MouthSight(sight, False)
    core = near & (np.abs(strip.across) < CORE_DIAMETERS * wire.diameter)
    top = float(np.median(strip.height[rows][:, core]))
    fits = abs(top - float(world_from_socket.position[2]) - wire.radius) < HEIGHT_M
    return MouthSight(sight if fits else Sight.UNCLEAR, fits)
