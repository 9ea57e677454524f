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
from remodel_skills.primitives.motions import is_free, move_to, straight_line
from remodel_skills.robot_context import RobotContext, Steps
from remodel_skills.runner import occupy
from remodel_work.geometry import Array, wrap_angle
from remodel_work.obstacles import WIRES, duct_name
from remodel_work.robot.arm import ToolPose

# A leading hand goes among other wires, which yield.
AMONG_WIRES = frozenset({WIRES})


def keeps_room(guide: RobotContext, corner: Array, slot: Array) -> bool:
    """Return whether a hand behind a corner (3,) is out of the way of one at a slot (3,) [m]."""
    return float(np.linalg.norm(slot - corner)) >= guide.parameters.fixture.duct_room_m


def keep_in_duct(guide: RobotContext, corner: Array, slot: Array) -> Steps[None]:
    """Take the closed eyelet back along a wire to its last corner, and keep the wire down there.

    Args:
        guide: its hand is at the last slot, its eyelet around the wire.
        corner: (3,) [m], world frame.
        slot: the last one, (3,) [m], world frame.
    """
    fixture = guide.parameters.fixture
    behind = corner + fixture.duct_corner_m / np.linalg.norm(slot - corner) * (slot - corner)
    here = guide.commanded
    z = max(lowest(guide), here.z - fixture.duct_lower_m)
    target = ToolPose(float(behind[0]), float(behind[1]), z, here.yaw)
    guide.keeps_wire = True
    yield from move_to(guide, target, guide.parameters.motion.approach_speed_m_s, in_ducts(guide))


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
    motion = guide.parameters.motion
    guide.keeps_wire = False
    yield from open_fingers(guide, guide.parameters.tool.open_m)
    behind, ducts = risen.at(z=guide.commanded.z), in_ducts(guide)
    if behind != guide.commanded and is_free(guide, behind, ducts):
        yield from move_to(guide, behind, motion.approach_speed_m_s, ducts)
    if guide.commanded.z < motion.travel_z_m:
        yield from _shed(guide)
        yield from move_to(
            guide, guide.commanded.at(z=motion.travel_z_m), motion.leave_speed_m_s, ducts
        )


def _shed(guide: RobotContext) -> Steps[None]:
    """Rise over the rims, and take the open fingers' notches from under a wire that lies in one."""
    motion, fixture = guide.parameters.motion, guide.parameters.fixture
    rims = max(duct.height for duct in guide.panel.ducts if duct.id in guide.wire.ducts)
    here, allowed = guide.commanded, in_ducts(guide)
    over = here.at(z=max(here.z, rims + fixture.duct_shed_over_m + guide.fingers.below))
    across = np.array([-math.sin(here.yaw), math.cos(here.yaw), 0.0])
    yield from move_to(guide, over, motion.leave_speed_m_s, allowed)
    to_both_sides = [
        over.moved(across, side * by) for by in fixture.duct_asides_m for side in (1, -1)
    ]
    for target in (*to_both_sides, over):
        if guide.arm.reaches(target) and is_free(guide, target, allowed):
            way = straight_line(guide, target, motion.leave_speed_m_s, allowed)
            if guide.space.has_way(way.postures(guide.arm)):
                yield from move_to(guide, target, motion.leave_speed_m_s, allowed)


def behind_hand(guide: RobotContext, holder: RobotContext) -> ToolPose:
    """Return where a leading hand rises that goes back along the wire, away from the holder."""
    here = guide.commanded
    back = np.array([math.cos(here.yaw), math.sin(here.yaw), 0.0])
    if back @ (here.position - holder.commanded.position) < 0:
        back = -back
    return here.moved(back, guide.parameters.fixture.duct_back_m)


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
    return guide.fingers.below + guide.parameters.tool.led_floor_clearance_m


def in_ducts(guide: RobotContext) -> Set[str]:
    """Return what a hand may touch between the walls of the wire's ducts.

    Open, it has less room there than it keeps from other things.
    """
    return AMONG_WIRES | {duct_name(name) for name in guide.wire.ducts}
