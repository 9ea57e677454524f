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
from remodel_sim.core.geometry import Pose

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
class Clip:
    """A clip; fields, units and frame as in remodel_msgs/Clip."""

    id: str
    pose: tuple[float, float, float]
    wire_diameter: float
    height: float
    length: float
    retention_force: float

    @property
    def panel_from_clip(self) -> Pose:
        """Its frame: x along the wire, z away from the plate, the origin on the plate."""
        x, y, yaw = self.pose
        return Pose.level(x, y, 0.0, yaw)

    @property
    def lip_radius(self) -> float:
        """Of each lip's round edge [m]."""
        return LIP_RADIUS_SHARE * self.wire_diameter

    @property
    def lip_aside(self) -> float:
        """From the middle to a closed lip's centre [m]."""
        return GAP_SHARE * self.wire_diameter / 2 + self.lip_radius

    @property
    def lip_height(self) -> float:
        """Of the lips' centres above the plate [m]."""
        apart = self.wire_diameter / 2 + self.lip_radius
        return self.height + PLAY_M + math.sqrt(apart**2 - self.lip_aside**2)

    @property
    def lip_travel(self) -> float:
        """By which a lip gives way [m]."""
        return self.wire_diameter / 2

    @property
    def lip_force(self) -> float:
        """With which each lip closes, so that the wire comes free at the retention force [N]."""
        angle = math.acos(self.lip_aside / (self.wire_diameter / 2 + self.lip_radius))
        rubbing = math.atan(LIP_FRICTION * WIRE_FRICTION)
        return self.retention_force / (2 * math.tan(angle + rubbing))


@dataclass(frozen=True)
class Duct:
    """A duct; fields, units and frame as in remodel_msgs/Duct."""

    id: str
    pose: tuple[float, float, float]
    length: float
    width: float
    height: float

    @property
    def panel_from_duct(self) -> Pose:
        """Its frame: x along the duct, z away from the plate, the origin on the plate."""
        x, y, yaw = self.pose
        return Pose.level(x, y, 0.0, yaw)


def clip_boxes(clip: Clip) -> tuple[Box, ...]:
    """Return the fixed parts of a clip, in its frame."""
    inner = clip.wire_diameter / 2 + PLAY_M
    floor = clip.height - clip.wire_diameter / 2
    top = clip.lip_height
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
    return tuple(
        Box((0.0, side * aside, duct.height / 2), size, FIXTURE_RGB) for side in (-1, 1)
    )
