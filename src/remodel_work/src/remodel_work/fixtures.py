r"""Fixtures of the plate: clips whose lips snap, ducts along the routes of wires, and rails.

Seen along the wire, a clip is a channel under two round lips that slide apart against a force:

        ( )   ( )   lips, a gap apart that is narrower than the wire
       |   (W)   |  wire and walls
       |_________|

At both ends of the channel two slopes lead the wire between the lips from aside. Closed fingertips
that press it in pass between them.

A wire of radius R that is pulled up meets lips of radius r under the angle a from the horizontal,
cos(a) = (gap / 2 + r) / (R + r). Each lip resists sideways with F, and rubs with the coefficient
mu = tan(p). The wire comes free at 2 F tan(a + p), and from above it goes in at as much.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from remodel_work.component_shape import Box
from remodel_work.panel import Duct, PanelClip, Rail

# Shares of the wire's diameter.
GAP_SHARE = 0.6
LIP_RADIUS_SHARE = 1 / 3
# Between wire and wall on each side, and between wire and lip above it [m].
PLAY_M = 0.0003
WALL_M = 0.002
# The slopes at each end: along the wire, through the plate, and above the lips; and the room that
# they leave, half as wide, for what presses the wire in [m].
SLOPE_LENGTH_M = 0.003
SLOPE_THICKNESS_M = 0.0015
SLOPE_ABOVE_LIPS_M = 0.006
SLOPE_ROOM_M = 0.0045
# Of lip and wire together, as Bullet multiplies them: a lip of polyamide, and PVC with 0.5.
LIP_FRICTION = 0.3
WIRE_FRICTION = 0.5
FIXTURE_RGB = (0.86, 0.86, 0.82)
RAIL_RGB = (0.72, 0.73, 0.70)
# Pieces of a wall that are shorter are left out [m].
LEAST_PIECE_M = 0.0005
# Sine of the angle between parallel ducts.
PARALLEL = 1e-6


@dataclass(frozen=True)
class Lips:
    """The lips of a clip, in its frame.

    Attributes:
        radius: of each one's round edge [m].
        aside: from the middle to a closed one's centre [m].
        height: of their centres above the plate [m].
        travel: by which each gives way [m].
        force: with which each closes [N].
    """

    radius: float
    aside: float
    height: float
    travel: float
    force: float


def lip_top(clip: PanelClip) -> float:
    """Return the height of a clip's top above the plate [m]."""
    lips = lips_of(clip)
    return lips.height + lips.radius


def lips_of(clip: PanelClip) -> Lips:
    """Return the lips that release a wire at the clip's retention force."""
    radius = LIP_RADIUS_SHARE * clip.wire_diameter
    aside = GAP_SHARE * clip.wire_diameter / 2 + radius
    apart = clip.wire_diameter / 2 + radius
    angle, rubbing = math.acos(aside / apart), math.atan(LIP_FRICTION * WIRE_FRICTION)
    return Lips(
        radius=radius,
        aside=aside,
        height=clip.height + PLAY_M + math.sqrt(apart**2 - aside**2),
        travel=clip.wire_diameter / 2,
        force=clip.retention_force / (2 * math.tan(angle + rubbing)),
    )


def clip_boxes(clip: PanelClip) -> tuple[Box, ...]:
    """Return the fixed parts of a clip, in its frame."""
    inner = clip.wire_diameter / 2 + PLAY_M
    floor = clip.height - clip.wire_diameter / 2
    top = lips_of(clip).height
    outer = 2 * (inner + WALL_M)
    walls = [
        Box(
            (0.0, side * (inner + WALL_M / 2), (floor + top) / 2),
            (clip.length, WALL_M, top - floor),
            FIXTURE_RGB,
        )
        for side in (-1, 1)
    ]
    base = Box((0.0, 0.0, floor / 2), (clip.length, outer, floor), FIXTURE_RGB)
    slopes = [_slope(clip, inner, side, end) for side in (-1, 1) for end in (-1, 1)]
    return base, *walls, *slopes


def _slope(clip: PanelClip, inner: float, side: int, end: int) -> Box:
    """Return a plate that rises outward from beside the wire, at 45 degrees or flatter."""
    to_lips = lip_top(clip) - clip.height
    steepness = math.atan2(to_lips, max(to_lips, SLOPE_ROOM_M - inner))
    rise = to_lips + SLOPE_ABOVE_LIPS_M
    run = rise / math.tan(steepness)
    out, down = math.sin(steepness), math.cos(steepness)
    aside = inner + run / 2 + out * SLOPE_THICKNESS_M / 2
    height = clip.height + rise / 2 - down * SLOPE_THICKNESS_M / 2
    return Box(
        (end * (clip.length + SLOPE_LENGTH_M) / 2, side * aside, height),
        (SLOPE_LENGTH_M, math.hypot(run, rise), SLOPE_THICKNESS_M),
        FIXTURE_RGB,
        rpy=(side * steepness, 0.0, 0.0),
    )


def duct_boxes(duct: Duct, others: Iterable[Duct] = ()) -> tuple[Box, ...]:
    """Return the walls of a duct, in its frame, open where it meets others.

    Seen from aside, the wall of a slotted duct is a comb:

        ||||||||||||||||||  fingers, with slots between them that are open at the top
        ||||||||||||||||||
        __________________  solid up to the slots' bottom
    """
    aside = (duct.width + WALL_M) / 2
    others = [other for other in others if other is not duct]
    return tuple(
        box
        for side in (-1, 1)
        for piece in _wall_pieces(duct, side * aside, others)
        for box in _wall(duct, side * aside, piece)
    )


def _wall_pieces(duct: Duct, aside: float, others: Iterable[Duct]) -> list[tuple[float, float]]:
    """Return from where to where along a duct its wall stands, without the inside of others."""
    pieces = [(-duct.length / 2, duct.length / 2)]
    for other in others:
        inside = _inside(duct, aside, other)
        if inside is not None:
            first, last = inside
            pieces = [
                piece
                for start, end in pieces
                for piece in ((start, min(end, first)), (max(start, last), end))
                if piece[1] - piece[0] > LEAST_PIECE_M
            ]
    return pieces


def _inside(duct: Duct, aside: float, other: Duct) -> tuple[float, float] | None:
    """Return from where to where along a duct its wall is inside another one."""
    frame = other.panel_from_duct.inverse() @ duct.panel_from_duct
    start = frame.apply(np.array([0.0, aside, 0.0]))[:2]
    along = frame.rotation[:2, 0]
    first, last = -duct.length / 2, duct.length / 2
    # A wall that only touches the other duct's end or its wall is not inside it.
    for place, step, half in zip(
        start, along, (other.length / 2 - WALL_M, other.width / 2 + WALL_M / 2), strict=True
    ):
        if abs(step) < PARALLEL:
            if abs(place) >= half - WALL_M:
                return None
            continue
        low, high = sorted(((-half - place) / step, (half - place) / step))
        first, last = max(first, float(low)), min(last, float(high))
    return (first, last) if last - first > LEAST_PIECE_M else None


def _wall(duct: Duct, aside: float, piece: tuple[float, float]) -> Iterator[Box]:
    """Yield the boxes of a piece of a wall: one, or a strip with fingers."""

    def box(start: float, end: float, low: float, high: float) -> Box:
        centre = ((start + end) / 2, aside, (low + high) / 2)
        return Box(centre, (end - start, WALL_M, high - low), FIXTURE_RGB)

    start, end = piece
    if not duct.slot_pitch:
        yield box(start, end, 0.0, duct.height)
        return
    if duct.slot_bottom > 0:
        yield box(start, end, 0.0, duct.slot_bottom)
    half = (duct.slot_pitch - duct.slot_width) / 2
    # One slot is in the middle of the duct: fingers stand half a pitch beside it.
    first = math.floor(start / duct.slot_pitch - 0.5)
    last = math.ceil(end / duct.slot_pitch - 0.5)
    for index in range(first, last + 1):
        middle = (index + 0.5) * duct.slot_pitch
        left, right = max(start, middle - half), min(end, middle + half)
        if right - left > LEAST_PIECE_M:
            yield box(left, right, duct.slot_bottom, duct.height)


def rail_box(rail: Rail) -> Box:
    """Return a mounting rail, in its frame."""
    return Box((0.0, 0.0, rail.height / 2), (rail.length, rail.width, rail.height), RAIL_RGB)
