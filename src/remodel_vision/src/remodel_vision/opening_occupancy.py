"""Classify what a picture shows before the opening of a terminal.

The strip of the picture that the opening's axis crosses just outside it is unrolled: one row for
each distance from the face, one column for each place across. What lies behind looks alike all
along a row, so most of a row shows what its middle would look like if nothing were there. Rows that
look so show an empty axis. Rows whose middle differs show something thin, which has a colour and,
when it is an end that is not pushed in, a ferrule. It goes into the opening when a line of that
colour, found in the picture as all cables are, leads there.

One picture that shows the axis empty proves that nothing sits in the opening. That something sits
there takes two pictures from places apart: what passes above or below the axis lies beside it in
one of them. A picture with depth measures the height of an object by itself, and needs no colours
to show that nothing is as high as the opening.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.wires import DISTINCT_COLOURS, rgbs_of
from remodel_vision.colour import WIRE_SHADES, ferrule_mask
from remodel_vision.laid_wire import WireLines, crossings
from remodel_work.camera import Picture
from remodel_work.component_shape import LABEL_CELLS, label_corners
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Component, PanelWire

# The strip: distances from the face along the axis, and places across it [m].
STEP_M = 0.00025
REACH_M = 0.014
HALF_WIDTH_M = 0.009  # a neighbour is 12 mm away
# What is nearer to the face than the first is mixed with the funnel's rim; within the second a
# wire is as straight as its opening [m].
RIM_M, STRAIGHT_M = 0.0020, 0.0080
# A seated wire shows within so many diameters of the axis, and so much more per length that it has
# gone on.
SHOWN_DIAMETERS, LEAVING = 0.9, 0.7
# Differences from what is behind: noise stays below the first, a white wire on white is above the
# second [grey levels].
NOISE_LEVELS, SHOWN_LEVELS = 12.0, 16.0
# Share of the rows that must show it: a white wire looks like the plate where its shade is right.
MOST = 0.75
# A seated wire's middle line is so near to the axis at the face [m].
ASIDE_M = 0.0018
# A ferrule that shows by more than the first is not pushed in to the bottom; by less than the
# second it is [m].
PUSHED_OUT_M, PUSHED_IN_M = 0.0045, 0.0032
# Wires of other orders are so thick [m].
OTHER_DIAMETERS_M = (0.0018, 0.0030, 0.0045)
# A wire's colour is the one asked for when no other is nearer by this much; it is another one when
# one is nearer by more than the second [grey levels].
SAME_LEVELS, OTHER_LEVELS = 6.0, 20.0
# Its distance from that colour is at most this [grey levels].
FAR_LEVELS = 60.0
# A label's white and a housing under the cell's usual light; white is overexposed from the third on
# [grey levels]. With less than this share of the light colours are not judged.
WHITE_LEVEL, HOUSING_LEVEL, FULL_LEVEL, DARK = 246.0, 92.0, 254.0, 0.25
# Heights by depth may err by this much [m].
HEIGHT_M = 0.005
# An opening is empty when less than this share of the rows shows something as high as it is: the
# housing hides some of them from a camera that looks past it.
HIDDEN_SHARE = 0.5
# A wire shows over this share of its diameter, a ferrule over this one.
SHOWN_SHARE, LEAST_FERRULE = 0.6, 0.4
# The colour is taken from what differs by this share of the most, clear of the ferrule, from so
# many samples.
CORE_SHARE, CLEAR_OF_FERRULE_M, LEAST_SAMPLES = 0.8, 0.0008, 20

Mask = npt.NDArray[np.bool_]


class Occupancy(Enum):
    """What a picture shows before an opening."""

    WIRE = "a wire of that colour goes into the opening"
    OTHER_WIRE = "a wire of another colour goes into the opening"
    LOOSE_END = "an end lies before the opening"
    EMPTY = "nothing is before the opening"
    UNCLEAR = "it is not visible what is before the opening"


@dataclass(frozen=True)
class OpeningObservation:
    """What one picture shows.

    Attributes:
        occupancy: what it shows.
        verified: whether this picture alone is enough: nothing was seen, or its height too.
    """

    occupancy: Occupancy
    verified: bool


def combine(observations: Sequence[OpeningObservation]) -> Occupancy:
    """Return what several pictures show together; UNCLEAR as long as they do not prove it."""
    if any(seen.occupancy is Occupancy.EMPTY for seen in observations):
        return Occupancy.EMPTY
    clear = [seen for seen in observations if seen.occupancy is not Occupancy.UNCLEAR]
    kinds = {seen.occupancy for seen in clear}
    if len(kinds) == 1 and (len(clear) > 1 or clear[0].verified):
        return clear[0].occupancy
    return Occupancy.UNCLEAR


@dataclass(frozen=True, eq=False)
class Strip:
    """The unrolled picture before an opening.

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
    """Return the strip before an opening; None when it is not wholly in the picture."""
    along = np.arange(0.0, REACH_M, STEP_M)
    across = np.arange(-HALF_WIDTH_M, HALF_WIDTH_M + STEP_M / 2, STEP_M)
    grid = np.stack(np.meshgrid(-along, across, indexing="ij"), axis=-1).reshape(-1, 2)
    points = world_from_socket.apply(np.column_stack([grid, np.zeros(len(grid))]))
    if not picture.view.sees(points, 1.0):
        return None
    pixels = picture.view.project(points)
    shape = len(along), len(across)
    smooth = np.asarray(cv2.GaussianBlur(picture.rgb, (0, 0), 0.7), np.uint8)
    rgb = _sampled(smooth, pixels).reshape(*shape, 3)
    if picture.depth is None:
        return Strip(along, across, rgb, None)
    depths = _sampled(np.asarray(picture.depth, np.float32), pixels)
    height = picture.view.at_depth(pixels, depths)[:, 2].reshape(shape)
    return Strip(along, across, rgb, height)


def light_on(picture: Picture, component: Component, pose: Pose, *, label: bool = True) -> float:
    """Return how bright a component's top is, as a share of the cell's usual light.

    It is measured on its label's white or, where that is overexposed or there is no label, on the
    housing beside the label's place.
    """
    corners = label_corners(component)
    middle = corners.mean(axis=0)
    rim = middle + (corners - middle) * (1 + 1 / LABEL_CELLS)
    share = np.linspace(0, 1, 25)[:, None]
    sides = [a + share * (b - a) for a, b in zip(rim, np.roll(rim, -1, axis=0), strict=True)]
    white = _brightness(picture, pose.apply(np.vstack(sides)))
    if label and white < FULL_LEVEL:
        return white / WHITE_LEVEL
    depth, width, height = component.size
    out = (component.marker_size * (0.5 + 1 / LABEL_CELLS) + depth / 2) / 2
    beside = np.linspace(-0.4, 0.4, 25) * width
    housing = np.array([[x, y, height] for x in (-out, out) for y in beside])
    return _brightness(picture, pose.apply(housing)) / HOUSING_LEVEL


def _brightness(picture: Picture, points: Array) -> float:
    levels = _sampled(picture.rgb, picture.view.project(points))
    return float(np.median(levels.mean(axis=-1)))


def observe_opening(
    picture: Picture, world_from_socket: Pose, wire: PanelWire, light: float
) -> OpeningObservation:
    """Return what a picture shows before an opening.

    Args:
        picture: of it.
        world_from_socket: the opening's frame, x into the terminal, by the component's label.
        wire: whose end is asked for.
        light: on it, as a share of the cell's usual light.
    """
    strip = unroll(picture, world_from_socket)
    if strip is None:
        return OpeningObservation(Occupancy.UNCLEAR, False)
    if _is_low(strip, world_from_socket, wire):
        return OpeningObservation(Occupancy.EMPTY, True)
    rows = _straight_rows(strip)
    near = _near_axis(strip, wire)
    # How far each place is from what most of its row shows [grey levels].
    behind = np.median(strip.rgb, axis=1, keepdims=True)
    differs = np.where(near, np.linalg.norm(strip.rgb - behind, axis=-1), 0.0)
    shown = _most(differs, round(SHOWN_SHARE * wire.diameter / STEP_M))
    # What lies across the axis covers some of it; a wire that goes on behind it shows beyond.
    goes_on = np.mean(shown[strip.along > STRAIGHT_M] > SHOWN_LEVELS) >= MOST
    if np.all(shown[rows] < NOISE_LEVELS) and not goes_on:
        # By its depth, something wide lies there that looks alike all along its rows.
        is_empty = strip.height is None
        return OpeningObservation(Occupancy.EMPTY if is_empty else Occupancy.UNCLEAR, is_empty)
    if np.mean(shown[rows] > SHOWN_LEVELS) < MOST:
        return OpeningObservation(Occupancy.UNCLEAR, False)
    # The middle of what shows: its rims are mixed with what is behind.
    object_mask = rows[:, None] & (differs > np.maximum(SHOWN_LEVELS, CORE_SHARE * shown[:, None]))
    ferrule = _ferrule_length(strip, wire)
    if ferrule > PUSHED_OUT_M:
        occupancy = Occupancy.LOOSE_END
    elif ferrule > PUSHED_IN_M:
        occupancy = Occupancy.UNCLEAR
    else:
        beyond = strip.along > ferrule + CLEAR_OF_FERRULE_M
        occupancy, colour = _whose(strip.rgb[object_mask & beyond[:, None]], wire, light)
        diameters = (wire.diameter,) if colour == wire.colour else OTHER_DIAMETERS_M
        lines = WireLines(picture, replace(wire, colour=colour), diameters=diameters)
        if occupancy is not Occupancy.UNCLEAR and not _leads_in(lines, world_from_socket):
            occupancy = Occupancy.UNCLEAR
    return _at_height(occupancy, strip, object_mask, world_from_socket, wire=wire)


def is_seen_empty(picture: Picture, world_from_socket: Pose, wire: PanelWire) -> bool:
    """Return whether a picture's depth shows that nothing goes into an opening.

    False means that something does, that something hides it, or that there is no depth.

    Args:
        picture: of it.
        world_from_socket: the opening's frame, x into the terminal.
        wire: that would be there.
    """
    strip = unroll(picture, world_from_socket)
    return strip is not None and _is_low(strip, world_from_socket, wire)


def _straight_rows(strip: Strip) -> Mask:
    """Return the rows (n,) in which a wire is as straight as its opening."""
    return np.asarray((strip.along >= RIM_M) & (strip.along <= STRAIGHT_M))


def _near_axis(strip: Strip, wire: PanelWire) -> Mask:
    """Return where (n, m) a seated wire may show."""
    half = SHOWN_DIAMETERS * wire.diameter + LEAVING * np.clip(strip.along - RIM_M, 0.0, None)
    return np.asarray(np.abs(strip.across) <= half[:, None])


def _is_low(strip: Strip, world_from_socket: Pose, wire: PanelWire) -> bool:
    """Return whether all that is seen before an opening lies lower than it, by its depth."""
    if strip.height is None:
        return False
    is_high = strip.height > float(world_from_socket.position[2]) - HEIGHT_M
    shows = (is_high & _near_axis(strip, wire)).any(axis=1)
    return float(np.mean(shows[_straight_rows(strip)])) < HIDDEN_SHARE


def _sampled(image: npt.NDArray[np.integer[Any] | np.floating[Any]], pixels: Array) -> Array:
    at = pixels.astype(np.float32)
    values = cv2.remap(image, at[None, :, 0], at[None, :, 1], cv2.INTER_LINEAR)[0]
    return np.asarray(values, np.float64)


def _most(differs: Array, count: int) -> Array:
    """Return the mean of each row's largest differences, so many of them."""
    return np.asarray(np.sort(differs, axis=1)[:, -count:].mean(axis=1))


def _ferrule_length(strip: Strip, wire: PanelWire) -> float:
    """Return how far from the face a ferrule shows on the axis [m]; 0 when none does."""
    levels = np.clip(np.rint(strip.rgb), 0, 255).astype(np.uint8)
    near = np.abs(strip.across) <= SHOWN_DIAMETERS * wire.diameter
    width = ferrule_mask(levels)[:, near].sum(axis=1) * STEP_M
    seen = np.flatnonzero(width > LEAST_FERRULE * wire.diameter)
    return float(strip.along[seen[-1]]) if len(seen) else 0.0


def _leads_in(lines: WireLines, world_from_socket: Pose) -> bool:
    """Return whether a line of the wire leads along the opening's axis into it."""
    socket_from_world = world_from_socket.inverse()
    for line in lines.passings(float(world_from_socket.position[2])):
        near = socket_from_world.apply(line)[:, :2]
        for first, last in itertools.product(crossings(near, -RIM_M), crossings(near, -STRAIGHT_M)):
            slope = (last - first) / (STRAIGHT_M - RIM_M)
            # The line is followed back to the face: a bent wire leaves the axis from there on.
            if abs(first - slope * RIM_M) < ASIDE_M and abs(slope) < LEAVING:
                return True
    return False


def _whose(pixels: Array, wire: PanelWire, light: float) -> tuple[Occupancy, str]:
    """Return whether pixels (n, 3) of what goes into the opening are a wire's, and their colour."""
    if light < DARK or len(pixels) < LEAST_SAMPLES:
        return Occupancy.UNCLEAR, wire.colour
    own = _away(pixels, wire.colour, light)
    others = [colour for colour in DISTINCT_COLOURS if colour != wire.colour]
    away = {colour: _away(pixels, colour, light) for colour in others}
    nearest = min(away, key=lambda code: away[code])
    if own < FAR_LEVELS and own < away[nearest] + SAME_LEVELS:
        return Occupancy.WIRE, wire.colour
    is_other = own > away[nearest] + OTHER_LEVELS
    return Occupancy.OTHER_WIRE if is_other else Occupancy.UNCLEAR, nearest


def _away(pixels: Array, colour: str, light: float) -> float:
    """Return the median distance of pixels (n, 3) from a wire's shades [levels in usual light]."""
    shades = np.outer(np.linspace(*WIRE_SHADES, 15), np.ravel(rgbs_of(colour))).reshape(-1, 3)
    seen = np.clip(255 * light * shades, 0.0, 255.0)
    away = np.linalg.norm(pixels[:, None] - seen, axis=-1).min(axis=1)
    return float(np.median(away)) / min(light, 1.0)


def _at_height(
    occupancy: Occupancy, strip: Strip, object_mask: Mask, world_from_socket: Pose, wire: PanelWire
) -> OpeningObservation:
    """Return what is seen, verified when it is as high as the opening, UNCLEAR when it is not."""
    if strip.height is None or occupancy is Occupancy.UNCLEAR:
        return OpeningObservation(occupancy, False)
    top = float(np.median(strip.height[object_mask]))
    fits = abs(top - float(world_from_socket.position[2]) - wire.radius) < HEIGHT_M
    return OpeningObservation(occupancy if fits else Occupancy.UNCLEAR, fits)
