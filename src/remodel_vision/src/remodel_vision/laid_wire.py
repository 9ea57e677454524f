"""The order's wire in a picture, and where it runs past a place.

The detector finds what is seen of the wire, in pieces where something hides it. From an end on they
are joined as strands are: the piece comes next to which the wire has to bend least.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.wires import rgbs_of
from remodel_vision.cables import detect_cables
from remodel_vision.cables.lines import across_gap, arc_lengths
from remodel_work.camera import Picture
from remodel_work.geometry import Array, Pose
from remodel_work.panel import PanelWire

# Something may hide the wire over so much [widths]; the price of such a gap, that of a bend by an
# angle s and another one t being s^2 + s t + t^2, and the most that a joint costs.
GAP_WIDTHS, GAP_PRICE, MOST = 20.0, 0.33, 0.6
# A piece passes a point this near to it [widths], and is entered so far ahead of it.
PASSING_WIDTHS, AHEAD_WIDTHS = 2.5, 1.0
# A piece's heading is that of so much of it [widths].
HEADING_WIDTHS = 4.0
# Lines followed from both ends meet within so many widths: a fork hides that much. A pixel of
# length too much or too little counts as so many of a gap.
MEETING_WIDTHS, LENGTH_PRICE = 6.0, 0.2
# Beyond its last point a piece goes on straight for so much [widths]: a clip hides a wire's end.
PROLONG_WIDTHS = 2.0


@dataclass(frozen=True, eq=False)
class WireLines:
    """What a picture shows of a wire.

    Attributes:
        picture: from above.
        wire: whose colour and diameter are searched for.
        heights: of its axis in the world, roughly [m].
        diameters: searched for [m]; without any that of the wire.
    """

    picture: Picture
    wire: PanelWire
    heights: tuple[float, ...] = ()
    diameters: tuple[float, ...] = ()

    @property
    def width(self) -> float:
        """Of the wire on the plate [px]."""
        return self._width_of(self.wire.diameter, self.wire.radius)

    def _width_of(self, diameter: float, height: float) -> float:
        return max(2.0, diameter / self.picture.view.metres_per_pixel(height))

    @property
    def length(self) -> float:
        """Of the wire on the plate [px]."""
        return self.wire.length / self.picture.view.metres_per_pixel(self.wire.radius)

    @property
    def colours(self) -> tuple[Array, ...]:
        """Of the wire, RGB (3,) each, 0 to 255."""
        rgbs = rgbs_of(self.wire.colour)
        return tuple(255.0 * np.array(rgb, dtype=np.float64) for rgb in rgbs)

    @cached_property
    def pieces(self) -> tuple[Array, ...]:
        """Centrelines (n, 2) [px] of the pieces that are seen, the longest first."""
        found = detect_cables(
            self.picture.rgb,
            colours=[colour.tolist() for colour in self.colours],
            widths=[
                self._width_of(diameter, height)
                for diameter in self.diameters or (self.wire.diameter,)
                for height in {self.wire.radius, *self.heights}
            ],
        )
        return tuple(cable.centreline for cable in found.cables)

    def passings(self, height: float) -> Iterator[Array]:
        """Yield the pieces (n, 3) [m], world frame, of a wire at a height [m], a little longer."""
        for piece in self._longer_pieces:
            yield self.picture.view.on_plane(piece, height)

    @cached_property
    def _longer_pieces(self) -> tuple[Array, ...]:
        """The pieces (n, 2) [px], prolonged at both ends."""
        return tuple(
            _prolonged(_prolonged(piece, self.width)[::-1], self.width) for piece in self.pieces
        )

    def continue_from(self, point: Array, heading: Array) -> bool:
        """Return whether the wire goes on from a point (2,) [px] along a unit vector (2,)."""
        return bool(_options(dict(enumerate(self.pieces)), point, heading, self.width))


def follow(
    pieces: Sequence[Array], start: Array, heading: Array, width: float, longest: float
) -> Array:
    """Return the line (n, 2) [px] from a point on, along pieces that continue each other.

    Args:
        pieces: polylines (n, 2) [px].
        start: (2,) where the insulation begins [px].
        heading: (2,) unit vector into the wire.
        width: of the wire [px].
        longest: where the line ends at the latest [px].
    """
    left = dict(enumerate(pieces))
    line = start[None]
    while left and arc_lengths(line)[-1] < longest:
        options = _options(left, line[-1], heading, width)
        if not options:
            break
        _, i, rest = min(options, key=lambda option: option[0])
        del left[i]
        gap = across_gap(line[-1], heading, rest[0], _heading(rest, width), step=width / 2)
        line = np.vstack([line, gap, rest])
        heading = -_heading(rest[::-1], width)
    return line[: int(np.searchsorted(arc_lengths(line), longest, side="right"))]


def joined(first: Array, last: Array, width: float, longest: float) -> Array | None:
    """Return one line (n, 2) [px] of two that were followed from its two ends.

    They are joined where they meet and the whole is as long as the wire; None where they do not
    meet.
    """
    gaps = np.linalg.norm(first[:, None] - last[None], axis=2)
    lengths = arc_lengths(first)[:, None] + arc_lengths(last)[None] + gaps
    cost = gaps + LENGTH_PRICE * np.abs(lengths - longest)
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return None if gaps[i, j] > MEETING_WIDTHS * width else np.vstack([first[: i + 1], last[j::-1]])


def _options(
    pieces: Mapping[int, Array], point: Array, heading: Array, width: float
) -> list[tuple[float, int, Array]]:
    """Return the pieces on which a line may go on: its price, number, and what of it is ahead."""
    return [
        (price, i, rest)
        for i, piece in pieces.items()
        for way in (piece, piece[::-1])
        if (rest := _rest(way, point, heading, width)) is not None
        and (price := _price(point, heading, rest, width)) < MOST
    ]


def _rest(piece: Array, point: Array, heading: Array, width: float) -> Array | None:
    """Return what of a piece (n, 2) lies ahead of a point; None when that is nothing."""
    away = np.linalg.norm(piece - point, axis=1)
    nearest = int(np.argmin(away))
    if away[nearest] < PASSING_WIDTHS * width:
        ahead = (piece[nearest:] - point) @ heading > AHEAD_WIDTHS * width
        piece = piece[nearest + int(np.argmax(ahead)) :] if ahead.any() else piece[:0]
    return piece if len(piece) > 1 else None


def _price(point: Array, heading: Array, piece: Array, width: float) -> float:
    """Return the price of going on from a point to a piece (n, 2)."""
    chord = piece[0] - point
    gap = float(np.linalg.norm(chord)) / (GAP_WIDTHS * width)
    if gap > 1:
        return math.inf
    s, t = _angle(heading, chord), _angle(chord, _heading(piece, width))
    return s * s - s * t + t * t + GAP_PRICE * gap


def _heading(line: Array, width: float) -> Array:
    """Return the unit vector from the first point of a line (n, 2) into it."""
    far = int(np.searchsorted(arc_lengths(line), HEADING_WIDTHS * width))
    way = line[min(max(far, 1), len(line) - 1)] - line[0]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9))


def _angle(a: Array, b: Array) -> float:
    """Return the angle from one vector (2,) to another [rad]."""
    return math.atan2(float(a[0] * b[1] - a[1] * b[0]), float(a @ b))


def _prolonged(line: Array, width: float) -> Array:
    """Return a line (n, 2) with one more point, straight on beyond its last."""
    return np.vstack([line, line[-1] - PROLONG_WIDTHS * width * _heading(line[::-1], width)])


# The height of a wire is measured so far along it to both sides of a place [m].
ALONG_M = np.linspace(-0.0015, 0.0015, 7)
# Wires that lie beside or over each other are so near [m]; so much of what is around them lies
# below the uppermost one's crest, but for the depth camera's noise [%].
BESIDE_M = 0.010
TOP_PERCENT = 95.0
# What stood somewhere before is found again so near to its place [m].
AGAIN_M = np.stack(np.meshgrid(*2 * [[-0.002, 0.0, 0.002]], [0.0]), axis=-1).reshape(-1, 3)
# Where colour does not show it, more than this share of the points that the camera sees across a
# wire's diameter must be new: a few always are, by the depth camera's noise.
LEAST_NEW = 0.4
# What is lower than this share of where a wire is expected is what it lies on.
LEAST_HEIGHT = 0.5
# A wire has these shades of its colour; another colour differs from all of them by so much
# [grey levels].
SHADES = (0.5, 1.0)
OTHER_COLOUR = 25.0
# To each side of where it is expected a wire is searched for around a circle [rad].
TURN_RAD = np.radians(60.0)
# The camera looks along the wire's height twice: once at the height that is expected.
LOOKS = 2


@dataclass(frozen=True)
class Passing:
    """How a wire passes a place.

    Attributes:
        aside: of its axis from the place's own, along its y [m].
        height: of its axis, world frame [m].
    """

    aside: float
    height: float


def wire_past(place: Pose, reach: float, lines: WireLines) -> Passing | None:
    """Return how a wire passes a place, or None where none is seen.

    Args:
        place: where its axis is expected, x along it, world frame.
        reach: how far to each side it is searched for [m].
        lines: of the wire, in a picture from above with depth.
    """
    return _passing_near(place, 0.0, reach, lines)


def _passing_near(place: Pose, near: float, reach: float, lines: WireLines) -> Passing | None:
    """Return how a wire passes a place nearest to so far aside of it [m]; None: none is seen."""
    height, aside = float(place.position[2]), near
    for _ in range(LOOKS):
        across = _across(place, height, reach, lines)
        if not across:
            return None
        aside = min(across, key=lambda y: abs(y - near))
        crest = place.apply(np.array([[x, aside, 0.0] for x in ALONG_M]))
        crest[:, 2] = height + lines.wire.radius
        height = float(np.median(heights_at(lines.picture, crest))) - lines.wire.radius
    return Passing(aside, height)


def _across(place: Pose, height: float, reach: float, lines: WireLines) -> list[float]:
    """Return how far aside of a place its wire's lines pass it, if they are so high [m]."""
    return [
        y
        for line in lines.passings(height)
        for y in crossings(place.inverse().apply(line)[:, :2], 0.0)
        if abs(y) <= reach
    ]


def uppermost_past(
    place: Pose, reach: float, lines: WireLines, before: Picture | None = None
) -> Passing | None:
    """Return how the uppermost of the wires beside each other passes a place; None: none is seen.

    Of several of its colour it is the highest; colour may not distinguish it from those below it:
    then depth alone counts. What stood there before does not count.

    Args:
        place: where its axis is expected, x along it, world frame.
        reach: how far to each side they are searched for [m].
        lines: of one of the wires, in a picture from above with depth.
        before: with depth, from above, without it; None: there is none.
    """
    expected, radius = float(place.position[2]), lines.wire.radius
    asides = _across(place, expected, reach, lines)
    passings = [p for aside in asides if (p := _passing_near(place, aside, reach, lines))]
    if before is not None:
        passings = [p for p in passings if is_new(p, place, before, radius)]
    passing = max(passings, key=lambda p: p.height, default=None)
    near = Passing(0.0, expected) if passing is None else passing
    at = place.apply(np.array([0.0, near.aside, near.height - expected]))
    surface = _surface_around(lines.picture, at, reach + BESIDE_M)[0]
    x, y, z = place.inverse().apply(surface).T
    across = (np.abs(x) <= ALONG_M[-1]) & (np.abs(y - near.aside) <= reach)
    surface, y, z = surface[across], y[across], z[across]
    is_there = np.full(len(y), True) if before is None else are_new(surface, before, radius)
    if passing is None and before is not None:
        aside = _where_most(y[is_there], radius, LEAST_NEW * len(y) * radius / reach)
        if aside is None:
            return None
        is_there &= np.abs(y - aside) <= radius
    else:
        is_there &= np.abs(y - near.aside) <= BESIDE_M
    if not is_there.any():
        return passing
    y, z = y[is_there], z[is_there]
    top = float(np.percentile(z, TOP_PERCENT))
    height = expected + top - radius
    least = LEAST_HEIGHT * expected if passing is None else passing.height + radius
    if height < least:
        return passing
    return Passing(float(np.mean(y[z > top - radius / 2])), height)


def _where_most(aside: Array, radius: float, least: float) -> float | None:
    """Return where, within a wire's radius [m] to each side, most points are (n,) [m].

    None: nowhere are more than `least`.
    """
    counts = (np.abs(aside[:, None] - aside) <= radius).sum(axis=1)
    return float(aside[counts.argmax()]) if counts.max(initial=0) > least else None


def is_new(passing: Passing, place: Pose, before: Picture, radius: float) -> bool:
    """Return whether a wire of a radius [m] that passes a place was not there before."""
    crest = [0.0, passing.aside, passing.height + radius - float(place.position[2])]
    return bool(are_new(place.apply(np.array([crest])), before, radius / 2)[0])


def are_new(points: Array, before: Picture, rise: float) -> npt.NDArray[np.bool_]:
    """Return which points (n, 3) [m] of a surface are of a wire that was not there before.

    Args:
        points: world frame.
        before: with depth, from above.
        rise: how far above what stood there the wire is at least [m].
    """
    again = (points[:, None] + AGAIN_M).reshape(-1, 3)
    stood = heights_at(before, again).reshape(len(points), -1).max(axis=1)
    return points[:, 2] > stood + rise


def points_of_colour(lines: WireLines, point: Array, reach: float) -> Array:
    """Return what has a wire's colour around a point (3,), as points (n, 3) [m], world frame.

    Args:
        lines: of the wire, in a picture from above with depth.
        point: in the middle, world frame [m].
        reach: how far along the picture's sides it is searched for [m].
    """
    points, colours = _surface_around(lines.picture, point, reach)
    is_own = np.zeros(len(points), bool)
    for own in lines.colours:
        shades = np.clip(colours @ own / float(own @ own), *SHADES)
        is_own |= np.linalg.norm(colours - shades[:, None] * own, axis=1) < OTHER_COLOUR
    return points[is_own]


def _surface_around(picture: Picture, point: Array, reach: float) -> tuple[Array, Array]:
    """Return what a depth camera sees around a point (3,).

    Returns:
        Points (n, 3) [m], world frame, and their colours (n, 3), 0 to 255.
    """
    assert picture.depth is not None, "the camera measures depth"
    column, row = np.rint(picture.view.project(point)[0]).astype(int)
    far = math.ceil(reach / picture.view.metres_per_pixel(float(point[2])))
    height, width = picture.depth.shape
    rows = np.arange(max(0, row - far), min(height, row + far + 1))
    columns = np.arange(max(0, column - far), min(width, column + far + 1))
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2).astype(np.float64)
    at = np.ix_(rows, columns)
    points = picture.view.at_depth(pixels, picture.depth[at].ravel())
    return points, picture.rgb[at].reshape(-1, 3).astype(np.float64)


def wire_around(centre: Array, radius: float, towards: float, lines: WireLines) -> float | None:
    """Return in which direction a wire crosses a circle on the plate, or None where none is seen.

    Args:
        centre: of the circle, (2,) [m], world frame.
        radius: of the circle [m].
        towards: direction in which it is searched for, up to TURN_RAD to each side [rad].
        lines: of the wire, in a picture from above.

    Returns:
        The angle from `towards` [rad].
    """
    turns = []
    for line in lines.passings(lines.wire.radius):
        way = (line[:, :2] - centre) @ np.array([1.0, 1.0j]) * np.exp(-1j * towards)
        polar = np.column_stack([np.abs(way) - radius, np.unwrap(np.angle(way))])
        # A line past the centre is unwrapped to either side.
        turns += [math.remainder(turn, math.tau) for turn in crossings(polar, 0.0)]
    return min((turn for turn in turns if abs(turn) <= TURN_RAD), key=abs, default=None)


def crossings(line: Array, at: float) -> list[float]:
    """Return the second coordinates at which a line (n, 2) crosses a value of its first."""
    first, second = line[:, 0] - at, line[:, 1]
    i = np.flatnonzero((first[:-1] > 0) != (first[1:] > 0))
    share = first[i] / (first[i] - first[i + 1])
    found: list[float] = (second[i] + share * (second[i + 1] - second[i])).tolist()
    return found


def heights_at(picture: Picture, points: Array) -> Array:
    """Return the heights (n,) [m] that a depth camera sees in directions of points (n, 3) [m]."""
    pixels = picture.view.project(points)
    u, v = pixels.astype(np.float32).T
    depths = cv2.remap(picture.single_depth, u, v, cv2.INTER_LINEAR)
    return picture.view.at_depth(pixels, np.asarray(depths, np.float64).ravel())[:, 2]
