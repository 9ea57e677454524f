r"""Fixtures that hold wires along their route: clips whose lips snap, and ducts.

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
from dataclasses import dataclass

from remodel_sim.core.workpiece.component_shape import Box
from remodel_sim.core.workpiece.panel import Duct, PanelClip

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


def duct_boxes(duct: Duct) -> tuple[Box, ...]:
    """Return the walls of a duct, in its frame."""
    aside = (duct.width + WALL_M) / 2
    size = (duct.length, WALL_M, duct.height)
    return tuple(Box((0.0, side * aside, duct.height / 2), size, FIXTURE_RGB) for side in (-1, 1))
