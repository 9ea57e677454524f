"""Where the feeder lays a wire: along the middle of a channel, end a beside its terminal.

Near end b the wire passes a fork, two low posts a few millimetres apart. They keep that end in the
middle of the channel while end a is carried away; else the stiff wire would swing it against a row,
where no finger gets behind it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_work.cell.presentation import Presentation
from remodel_work.geometry import Array, Pose
from remodel_work.layout import FEED_LIMIT_Y_M, feed_direction
from remodel_work.panel import Channel, Panel, PanelWire, WireEnd

# Around an end that is laid down again, the fork comes up so far behind the grasp.
FORK_BEHIND_GRASP_M = 0.045
# A wire that bows further off the line does not pass the fork.
MAX_BOW_M = 0.012


@dataclass(frozen=True)
class Feeder:
    """How a cell's feeder lays wires; lengths in metres.

    Attributes:
        overlap: tip a lies so far beyond its terminal: then turning it into the opening hardly
            drags the rest.
        fork_behind_tip: placing end a draws end b back by some 80 mm; fingers that grasp it then
            stay clear of the fork.
        fork_length, fork_height, fork_post: of the fork along the wire, up, and of a post across.
            It is as high as the hand leaves it when it carries a wire over: a wire that is lifted
            at its other end must not climb out.
        fork_clearance: between the wire and a post.
    """

    overlap: float
    fork_behind_tip: float
    fork_length: float
    fork_height: float
    fork_post: float
    fork_clearance: float


@dataclass(frozen=True, eq=False)
class Laying:
    """A wire in its channel; world frame.

    Attributes:
        tip_a: (2,) [m].
        direction: +1 when it runs from a towards +y, else -1.
        curvature: (n,) rest curvature at each joint [1/m].
        fork: (2,) centre of the fork [m].
    """

    tip_a: Array
    direction: int
    curvature: Array
    fork: Array

    def presentation(self, wire: PanelWire) -> Presentation:
        """Return where the ends should lie: the feeder knows no bow."""
        (x, y), out = self.tip_a, self.direction * math.pi / 2
        far = float(y) + self.direction * wire.length
        tips = {
            WireEnd.A: Pose.level(float(x), float(y), wire.radius, -out),
            WireEnd.B: Pose.level(float(x), far, wire.radius, out),
        }
        return Presentation(tips, self.direction)


def resting_place(panel: Panel, wire: PanelWire, end: WireEnd, overlap: float) -> tuple[Pose, int]:
    """Return where a wire's end can be laid down beside its terminal, and the wire's direction.

    The pose is the tip's, x out of the wire, in the middle of the channel in front of the terminal
    and `overlap` [m] beyond it; world frame. The direction is +1 when a to b runs towards +y.
    """
    openings = {e: panel.panel_from_socket(*wire.goes_to(e)).position for e in WireEnd}
    direction = feed_direction(float(openings[WireEnd.A][1]), float(openings[WireEnd.B][1]))
    out = direction if end is WireEnd.B else -direction
    channel = panel.channel_in_front_of(openings[end])
    tip = Pose.level(channel.x, float(openings[end][1]) + out * overlap, 0.0, out * math.pi / 2)
    return panel.world_from_panel @ tip, direction


def plan_laying(
    feeder: Feeder,
    panel: Panel,
    wire: PanelWire,
    channel: Channel,
    joints: int,
    noise: np.random.Generator,
) -> Laying:
    """Choose where a wire of `joints` + 1 links lies."""
    opening_a, opening_b = (
        panel.world_from_panel.apply(panel.panel_from_socket(*wire.goes_to(end)).position)
        for end in WireEnd
    )
    direction = feed_direction(float(opening_a[1]), float(opening_b[1]))
    start = float(opening_a[1]) - direction * feeder.overlap
    beyond = direction * start + wire.length - FEED_LIMIT_Y_M
    start -= direction * max(0.0, beyond)
    curvature = _random_bow(joints, wire, noise)
    along, aside = _shape(curvature, wire.length)
    fork_along = float(np.interp(wire.length - feeder.fork_behind_tip, along, along))
    fork_aside = float(np.interp(fork_along, along, aside))
    centre_x = float(panel.world_from_panel.apply(np.array([channel.x, 0.0, 0.0]))[0])
    # `aside` is to the left of the wire's own direction, which is -x when it runs towards +y.
    tip_a = np.array([centre_x + direction * fork_aside, start])
    fork = np.array([centre_x, start + direction * fork_along])
    return Laying(tip_a, direction, curvature, fork)


def _random_bow(joints: int, wire: PanelWire, noise: np.random.Generator) -> Array:
    s = np.linspace(0.0, 1.0, joints)
    waves = noise.uniform(0.5, 1.5) * s + noise.uniform(0.0, 1.0)
    curvature = wire.rest_curvature * (noise.standard_normal() + np.sin(2 * np.pi * waves))
    bow = float(np.abs(_shape(curvature, wire.length)[1]).max())
    return curvature * min(1.0, MAX_BOW_M / max(bow, 1e-9))


def _shape(curvature: Array, length: float) -> tuple[Array, Array]:
    """Return arc length and sideways offset of a slightly bent wire, (n,) [m] each."""
    s = np.linspace(0.0, length, len(curvature))
    step = s[1] - s[0]
    return s, np.cumsum(np.cumsum(curvature) * step) * step
