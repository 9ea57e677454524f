"""How a leading hand keeps a wire in its duct, and lets it go, as steps of an ability.

A wire is longer than its route. When its second end is inserted, what it is longer goes back into
the last duct, and lifts a stiff wire out of it at the corner, unless something keeps it down there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from itertools import pairwise

import numpy as np

from remodel_skills.primitives.grasping import open_fingers
from remodel_skills.primitives.motions import (
    APPROACH_SPEED,
    HAND_OPEN_M,
    TRAVEL_Z,
    is_free,
    move_to,
    straight_line,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_skills.runner import occupy
from remodel_work.geometry import Array, wrap_angle
from remodel_work.obstacles import WIRES, duct_name
from remodel_work.robot.arm import ToolPose

# A leading hand goes among other wires, which yield.
AMONG_WIRES = frozenset({WIRES})
# The leading hand begins to turn so far before a corner, and ends so far behind it [m].
CORNER_M = 0.030
# Behind the corner it keeps the wire so much lower than it led it [m]: released there, the wire
# stays; kept 10 mm higher, it sprang out as the hand opened (W10, W15).
LOWER_M = 0.018
# It does where it is so far from the last slot that the other hand can insert the end [m].
ROOM_M = 0.20
# It leaves the wire so far back along it [m], then upwards, so fast [m/s]. A wire that lies in the
# notch of an open finger slips out of it; if the hand rises faster, it is flung up between the
# fingers, and drawn out of the other hand.
BACK_M = 0.012
LEAVE_SPEED = 0.10
# It may stay there all the same, and the hand would lift it, and draw it out of its terminal on the
# way home. So the hand goes so far aside, both ways, as soon as it is so far above the rims [m]: a
# taut wire slips off by the shorter way, and a slack one, which the finger takes along, by the
# longer way.
ASIDES_M = (0.008, 0.018)
OVER_RIMS_M = 0.005


def keeps_room(corner: Array, slot: Array) -> bool:
    """Return whether a hand behind a corner (3,) is out of the way of one at a slot (3,) [m]."""
    return float(np.linalg.norm(slot - corner)) >= ROOM_M


def keep_in_duct(guide: RobotContext, corner: Array, slot: Array) -> Steps[None]:
    """Take the closed eyelet back along a wire to its last corner, and keep the wire down there.

    Args:
        guide: its hand is at the last slot, its eyelet around the wire.
        corner: (3,) [m], world frame.
        slot: the last one, (3,) [m], world frame.
    """
    behind = corner + CORNER_M / np.linalg.norm(slot - corner) * (slot - corner)
    here = guide.commanded
    z = max(lowest(guide), here.z - LOWER_M)
    target = ToolPose(float(behind[0]), float(behind[1]), z, here.yaw)
    guide.keeps_wire = True
    yield from move_to(guide, target, APPROACH_SPEED, in_ducts(guide))


def let_go(context: RobotContext) -> Steps[None]:
    """Have the leading hand of a cell release the wire that it keeps in its duct, if one does."""
    if context.keeps_wire:
        yield from _rise_from_wire(context)
    for guide in context.peers:
        if guide.keeps_wire and not guide.busy:
            yield from occupy([guide], _rise_from_wire(guide))


def _rise_from_wire(guide: RobotContext) -> Steps[None]:
    """Open a hand that keeps a wire in its duct, and rise: its eyelet kept it in the middle."""
    yield from withdraw(guide, guide.commanded)


def withdraw(guide: RobotContext, risen: ToolPose) -> Steps[None]:
    """Open a hand, and take it back along the wire in its duct, if it can, before it rises.

    Args:
        guide: the wire is in its eyelet, or between its fingers.
        risen: where it has room to rise to, from below there.
    """
    guide.keeps_wire = False
    yield from open_fingers(guide, HAND_OPEN_M)
    behind, ducts = risen.at(z=guide.commanded.z), in_ducts(guide)
    if behind != guide.commanded and is_free(guide, behind, ducts):
        yield from move_to(guide, behind, APPROACH_SPEED, ducts)
    if guide.commanded.z < TRAVEL_Z:
        yield from _shed(guide)
        yield from move_to(guide, guide.commanded.at(z=TRAVEL_Z), LEAVE_SPEED, ducts)


def _shed(guide: RobotContext) -> Steps[None]:
    """Rise over the rims, and take the open fingers' notches from under a wire that lies in one."""
    rims = max(duct.height for duct in guide.panel.ducts if duct.id in guide.wire.ducts)
    here, allowed = guide.commanded, in_ducts(guide)
    over = here.at(z=max(here.z, rims + OVER_RIMS_M + guide.fingers.below))
    across = np.array([-math.sin(here.yaw), math.cos(here.yaw), 0.0])
    yield from move_to(guide, over, LEAVE_SPEED, allowed)
    to_both_sides = [over.moved(across, side * by) for by in ASIDES_M for side in (1, -1)]
    for target in (*to_both_sides, over):
        if guide.arm.reaches(target) and is_free(guide, target, allowed):
            way = straight_line(guide, target, LEAVE_SPEED, allowed)
            if guide.space.has_way(way.postures(guide.arm)):
                yield from move_to(guide, target, LEAVE_SPEED, allowed)


def behind_hand(guide: RobotContext, holder: RobotContext) -> ToolPose:
    """Return where a leading hand rises that goes back along the wire, away from the holder."""
    here = guide.commanded
    back = np.array([math.cos(here.yaw), math.sin(here.yaw), 0.0])
    if back @ (here.position - holder.commanded.position) < 0:
        back = -back
    return here.moved(back, BACK_M)


def eyelet_yaw(guide: RobotContext, yaws: Sequence[float]) -> float:
    """Return the hand's yaw at the first of the wire's yaws, from which it turns to all others.

    Closed fingers look both ways along a wire: of the two yaws it takes the one from which it turns
    less far from its middle.
    """
    turns = np.concatenate([[0.0], np.cumsum([wrap_angle(b - a) for a, b in pairwise(yaws)])])
    base = guide.arm.base[3]
    middle = wrap_angle(yaws[0] + float(turns.max() + turns.min()) / 2 - base)
    flip = 0.0 if abs(middle) <= math.pi / 2 else math.copysign(math.pi, -middle)
    return base + float(middle) - float(turns.max() + turns.min()) / 2 + flip


def lowest(guide: RobotContext) -> float:
    """Return the lowest height of the tool at which the fingers clear the plate [m]."""
    return guide.fingers.below + 0.002


def in_ducts(guide: RobotContext) -> Set[str]:
    """Return what a hand may touch between the walls of the wire's ducts.

    Open, it has less room there than it keeps from other things.
    """
    return AMONG_WIRES | {duct_name(name) for name in guide.wire.ducts}
