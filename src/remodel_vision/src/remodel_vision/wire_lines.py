"""The order's wire in a picture: the detector's lines of its colour and width, put together.

The detector finds what is seen of the wire, in pieces where something hides it. From an end on they
are joined as strands are: the piece comes next to which the wire has to bend least.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from remodel_states.core.wires.wire_colours import rgbs_of
from remodel_vision.cables import detect_cables
from remodel_vision.cables.lines import across_gap, arc_lengths
from remodel_work.camera import Picture
from remodel_work.geometry import Array
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
