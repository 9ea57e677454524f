r"""How a cell presents wires: a feeder in a channel, or a magazine beside the plate.

The feeder lays a wire along the middle of a channel, end a beside its terminal. Near end b the wire
passes a fork, two low posts a few millimetres apart. They keep that end in the middle of the
channel while end a is carried away; else the stiff wire would swing it against a row, where no
finger gets behind it.

The magazine holds both ends level, the rest hangs. Seen from the board, with the wire running from
end a towards +y:

      tip a                                         tip b
        ====[clip]====[clip]       [clip]====[clip]====
                         \            /
                          \__________/      a loop that hangs below the table's level

The tips point away from each other along y, so the loop stays in one upright plane and clear of the
robot. The clips let an end out upwards, and are drawn in once a hand has it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from remodel_work.board_rules import GRASP_M
from remodel_work.component_shape import Box
from remodel_work.fixtures import SLOPE_LENGTH_M
from remodel_work.geometry import Array, Pose
from remodel_work.layout import FEED_LIMIT_Y_M, feed_direction
from remodel_work.panel import Channel, Panel, PanelClip, PanelWire, WireEnd


@dataclass(frozen=True, eq=False)
class Presentation:
    """A wire whose ends wait at known places.

    Attributes:
        tips: where each end's apex should be, x out of the wire, z of its axis, world frame.
        direction: +1 when the wire runs from end a towards +y, else -1.
    """

    tips: Mapping[WireEnd, Pose]
    direction: int


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


RGB = (0.16, 0.45, 0.30)
# Slim fingers grasp an end at least so far behind its tip [m]: nearer they would touch the device
# before the end is at its bottom.
LEAST_GRASP_M = 0.0215
# Clips hold each end so far behind its tip, their middles [m]: two, so that it lies level; the
# fingers grasp before them.
CLIPS_M = (0.044, 0.090)
CLIP_LENGTH_M = 0.008
# Fingers keep so far from where a clip may be [m].
BESIDE_CLIP_M = 0.0005
# A clip's wire lies so far above its foot [m].
FOOT_M = 0.010
# A clip lets the wire out at this force [N], or at so much per bending stiffness [1/m^2] if that is
# more: the stiffer a wire, the more its loop levers its end up.
RETENTION_N = 4.0
RETENTION_PER_STIFFNESS = 1.6e3
# A stop before the tip, from and to [m]: the loop of a short wire would push its ends outwards.
STOP_M = (0.001, 0.004)
# A wire hangs as a loop if it is so much longer than the span [m].
LEAST_SLACK_M = 0.02
# A wire is at least so long between what the clips of both ends hold [m].
LEAST_FREE_M = 0.05
# Ends are presented so exactly: along the wire, and in every other direction [m], at most.
ALONG_TOLERANCE_M = 0.002
ASIDE_TOLERANCE_M = 0.001


@dataclass(frozen=True)
class Magazine:
    """How a cell's magazine presents wires; world frame.

    Attributes:
        x: of both ends [m].
        height: of the ends' axes above the plate's surface [m].
        span: from tip to tip of a long wire [m]; for a shorter one, an end's clips slide inwards.
        y_min, y_max: within which both tips lie [m].
    """

    x: float
    height: float
    span: float
    y_min: float
    y_max: float

    def is_short(self, length: float) -> bool:
        """Return whether the clips of an end slide inwards for a wire of this length [m]."""
        return self.span_of(length) < self.span

    def span_of(self, length: float) -> float:
        """Return how far apart the tips of a wire of this length are presented [m].

        The clips hold the ends of a shorter wire if its loop bends them no more than that of the
        shortest one that hangs. A flat loop of length l between clamped ends has the shape
        a / 2 (1 - cos(2 pi x / l)), the first mode of a clamped column (Timoshenko and Gere, Theory
        of Elastic Stability, 2.2). It is pi^2 a^2 / (4 l) longer than its chord, and its curvature
        at the ends is 2 pi^2 a / l^2: for equal curvatures, what it is longer goes with l^3.
        """
        hanging = self.span + LEAST_SLACK_M
        if length >= hanging:
            return self.span
        held = 2 * held_length()
        return length - LEAST_SLACK_M * ((length - held) / (hanging - held)) ** 3


def plan_presentation(magazine: Magazine, panel: Panel, wire: PanelWire) -> Presentation:
    """Return where a wire is presented: as near to end a's terminal as the magazine can."""
    y_a, y_b = (
        float((panel.world_from_panel @ panel.panel_from_socket(*wire.goes_to(end))).position[1])
        for end in WireEnd
    )
    direction = feed_direction(y_a, y_b)
    half = magazine.span_of(wire.length) / 2
    middle = min(max(y_a, magazine.y_min + half), magazine.y_max - half)
    tips = {
        end: Pose.level(magazine.x, middle + out * half, magazine.height, out * math.pi / 2)
        for end, out in ((WireEnd.A, -direction), (WireEnd.B, direction))
    }
    return Presentation(tips, direction)


def find_wire_problems(panel: Panel) -> Iterator[str]:
    """Yield a sentence for every wire that cannot be presented."""
    for wire in panel.wires:
        if wire.connectors:
            yield f"wire {wire.id!r} has a connector; the cell's magazine holds ferrules only"


def disturbed(
    tips: Mapping[WireEnd, Pose], noise: np.random.Generator, *, is_short: bool
) -> dict[WireEnd, Pose]:
    """Return where tips that should be at poses really are.

    A short wire, which has no loop to take up a difference, lies too far to one side as a whole.
    """
    found: dict[WireEnd, Pose] = {}
    along = 0.0
    for end, tip in tips.items():
        drawn = noise.uniform(-ALONG_TOLERANCE_M, ALONG_TOLERANCE_M)
        along = -along if is_short and found else drawn
        aside, up = noise.uniform(-ASIDE_TOLERANCE_M, ASIDE_TOLERANCE_M, 2)
        found[end] = tip @ Pose.level(along, aside, up)
    return found


def fork_clips(wire: PanelWire, tip: Pose) -> tuple[tuple[PanelClip, Pose], ...]:
    """Return the clips that hold an end whose tip is at a pose, and each one's pose beside it."""
    foot = FOOT_M + wire.radius
    clip = PanelClip(
        id="",
        pose=(0.0, 0.0, 0.0),
        wire_diameter=wire.diameter,
        height=foot,
        length=CLIP_LENGTH_M,
        retention_force=max(RETENTION_N, RETENTION_PER_STIFFNESS * wire.bending_stiffness),
    )
    return tuple((clip, tip @ Pose.level(-back, 0.0, -foot)) for back in CLIPS_M)


def grasp_before_clips(slid: float, finger_width: float) -> float:
    """Return where an end is grasped, from its tip [m], between the tip and the clips.

    Args:
        slid: how far the end is behind the place where it is presented [m].
        finger_width: along the wire [m].
    """
    clip_from = CLIPS_M[0] - CLIP_LENGTH_M / 2 - SLOPE_LENGTH_M - ALONG_TOLERANCE_M - slid
    room = clip_from - BESIDE_CLIP_M - finger_width / 2
    return min(GRASP_M, max(LEAST_GRASP_M, room))


def stop_box(wire: PanelWire) -> Box:
    """Return the stop before a tip, in the frame of the tip, z up."""
    near, far = STOP_M
    size = (far - near, wire.diameter, wire.diameter)
    return Box(((near + far) / 2, 0.0, 0.0), size, RGB)


def held_length() -> float:
    """Return how much of the wire, from each tip, lies level [m]."""
    return CLIPS_M[-1] + CLIP_LENGTH_M / 2
