r"""Fixtures that hold wires along their way: clips whose lips snap, and ducts.

Seen along the wire, a clip is a channel under two round lips that slide apart against a force:

        ( )   ( )   lips, a gap apart that is narrower than the wire
       |   (W)   |  wire and walls
       |_________|

A wire of radius R that is pulled up meets lips of radius r under the angle a from the horizontal,
cos(a) = (gap / 2 + r) / (R + r). Each lip resists sideways with F, and rubs with the coefficient
mu = tan(p). The wire comes free at 2 F tan(a + p), and from above it goes in at as much.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from remodel_sim.core.component_shape import Box
from remodel_sim.core.panel import Clip, Duct

# Shares of the wire's diameter.
GAP_SHARE = 0.6
LIP_RADIUS_SHARE = 1 / 3
# Between wire and wall on each side, and between wire and lip above it [m].
PLAY_M = 0.0003
WALL_M = 0.002
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


def lips_of(clip: Clip) -> Lips:
    """Return the lips that let a wire go at the clip's retention force."""
    radius = LIP_RADIUS_SHARE * clip.wire_diameter
    aside = GAP_SHARE * clip.wire_diameter / 2 + radius
    apart = clip.wire_diameter / 2 + radius
    angle, rubbing = math.acos(aside / apart), math.atan(LIP_FRICTION * WIRE_FRICTION)
    return Lips(
        radius,
        aside,
        clip.height + PLAY_M + math.sqrt(apart**2 - aside**2),
        clip.wire_diameter / 2,
        clip.retention_force / (2 * math.tan(angle + rubbing)),
    )


def clip_boxes(clip: Clip) -> tuple[Box, ...]:
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
    return Box((0.0, 0.0, floor / 2), (clip.length, outer, floor), FIXTURE_RGB), *walls


def duct_boxes(duct: Duct) -> tuple[Box, ...]:
    """Return the walls of a duct, in its frame."""
    aside = (duct.width + WALL_M) / 2
    size = (duct.length, WALL_M, duct.height)
    return tuple(Box((0.0, side * aside, duct.height / 2), size, FIXTURE_RGB) for side in (-1, 1))
