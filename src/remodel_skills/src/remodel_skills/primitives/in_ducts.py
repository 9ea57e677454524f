"""Lead a wire into ducts, and tuck it in, as steps of an ability."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from remodel_skills.parameters import FixtureParameters
from remodel_skills.primitives.grasping import grips_nothing, open_fingers
from remodel_skills.primitives.motions import fingers_still, is_free, move_to, straight_line
from remodel_skills.primitives.observation.checks import Inspection, inspect_ducts
from remodel_skills.robot_context import RobotContext, Steps, occupy
from remodel_vision.laid_wire import Passing, uppermost_past
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.obstacles import WIRES, duct_name
from remodel_work.panel import Duct
from remodel_work.robot.arm import ToolPose

# A leading hand goes among other wires, which yield.
AMONG_WIRES = frozenset({WIRES})


@dataclass(frozen=True)
class LedPlace:
    """Where the leading hand goes.

    Attributes:
        at: of the eyelet's middle, (3,) [m], world frame.
        heading: in which the wire goes on [rad].
        yaw: in which the eyelet looks [rad].
    """

    at: Array
    heading: float
    yaw: float


def places_along(points: list[Array], fixture: FixtureParameters) -> Iterator[LedPlace]:
    """Yield where the leading hand goes along a polyline, (3,) each [m].

    The eyelet turns later than the way does: it looks along the wire that lies behind it, which
    would be kinked between its edges otherwise.
    """
    legs = [(a, b - a) for a, b in pairwise(points) if float(np.linalg.norm((b - a)[:2])) > 1e-3]
    headings = [math.atan2(leg[1], leg[0]) for _, leg in legs]
    lengths = [float(np.linalg.norm(leg)) for _, leg in legs]
    units = [leg / length for (_, leg), length in zip(legs, lengths, strict=True)]
    cuts = [
        unit * min(length / 2, fixture.duct_corner_m)
        for unit, length in zip(units, lengths, strict=True)
    ]
    yield LedPlace(legs[0][0] + cuts[0], headings[0], headings[0])
    for i in range(1, len(legs)):
        corner, last = legs[i][0], headings[i - 1]
        turn = float(wrap_angle(headings[i] - last))
        yield LedPlace(corner - cuts[i - 1], last, last)
        yield LedPlace(corner - cuts[i - 1], last + turn / 4, last)
        middle = corner + (cuts[i] - cuts[i - 1]) / 4
        yield LedPlace(middle, last + turn / 2, last + fixture.duct_turned_shares[0] * turn)
        yield LedPlace(middle, last + 3 * turn / 4, last + fixture.duct_turned_shares[0] * turn)
        yield LedPlace(corner + cuts[i], headings[i], last + fixture.duct_turned_shares[1] * turn)
        after = corner + units[i] * min(lengths[i] / 2, fixture.duct_straight_again_m)
        yield LedPlace(after, headings[i], headings[i])
    yield LedPlace(points[-1], headings[-1], headings[-1])


def last_turn(places: Sequence[LedPlace]) -> float:
    """Return by how much the way turns at its last corner [rad], positive to the left."""
    turns = [float(wrap_angle(b.heading - a.heading)) for a, b in pairwise(places)]
    return next((turn for turn in reversed(turns) if abs(turn) > 1e-6), 0.0)


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


@dataclass(frozen=True)
class Standing:
    """Where a wire stands out of a duct.

    Attributes:
        place: in the middle of the duct, at its rim, x along it, world frame.
        passing: how the wire passes the place.
        askew: its turn from the duct [rad].
    """

    duct: Duct
    place: Pose
    passing: Passing
    askew: float


def tuck_in(context: RobotContext) -> Steps[Inspection | None]:
    """Tuck a wire that is fixed at both ends into its ducts; return how it lies there at last.

    One duct after the other, it is taken where it is highest above the duct.

    Returns:
        None where it cannot be inspected.
    """
    motion, fixture = context.parameters.motion, context.parameters.fixture
    tucks: Counter[str] = Counter()  # in each duct
    is_taken = True

    def order(at: Standing) -> tuple[int, float]:
        return tucks[at.duct.id], -at.passing.height

    found = yield from inspect_ducts(context)
    while found is not None and tucks.total() < motion.tucks_of_refused:
        goes_on = is_taken and tucks.total() < motion.tucks
        best = min(_standing(context, found), key=order, default=None)
        if best is None or found.share >= fixture.duct_enough_share:
            break
        if not goes_on and found.outside_m <= found.most_outside_m(fixture):
            break
        tucks[best.duct.id] += 1
        is_taken = yield from _tuck(context, best)
        found = yield from inspect_ducts(context)
    return found


def _standing(context: RobotContext, found: Inspection) -> Iterator[Standing]:
    """Yield where a wire stands above a duct, and a hand has room to tuck it in."""
    fixture, looking = context.parameters.fixture, context.parameters.looking
    direction_m = looking.direction_m
    _, first, *corners, last, _ = (point[:2] for point in found.route)
    rooms = [(slot, fixture.tuck_loop_m) for slot in (first, last)] + [
        (corner, fixture.tuck_corner_m) for corner in corners
    ]
    for duct, places in found.places.items():
        for place in places:
            here = place.position
            if any(float(np.linalg.norm(here[:2] - point)) < room for point, room in rooms):
                continue
            at_rim = place @ Pose.level(0.0, 0.0, duct.height - float(here[2]))
            behind, passing, beyond = (
                uppermost_past(
                    at_rim @ Pose.level(x, 0.0, 0.0),
                    looking.tuck_search_m,
                    *found.seen_at(here),
                )
                for x in (-direction_m, 0.0, direction_m)
            )
            if passing is None or passing.height < duct.height + fixture.tuck_graspable_m:
                continue
            askew = 0.0
            if behind is not None and beyond is not None:
                askew = math.atan2(beyond.aside - behind.aside, 2 * direction_m)
            yield Standing(duct, at_rim, passing, askew)


def _tuck(context: RobotContext, standing: Standing) -> Steps[bool]:
    """Take a wire where it stands, and bring it down between the walls.

    Returns:
        Whether it was between the fingers.
    """
    fixture = context.parameters.fixture
    tool = context.parameters.tool
    motion = context.parameters.motion
    duct, place, passing = standing.duct, standing.place, standing.passing
    context.report(f"tucking the wire into duct {duct.id!r}", 0.96)
    yaw = eyelet_yaw(context, [place.yaw + standing.askew, place.yaw])
    x, y, _ = (float(v) for v in place.apply(np.array([0.0, passing.aside, 0.0])))
    over = duct.height + fixture.tuck_over_rim_m + context.fingers.below
    take = ToolPose(x, y, max(over, passing.height), yaw)
    # Over a wall the fingers would close on it there.
    lower = take.at(z=passing.height)
    is_beside = abs(passing.aside) >= duct.width / 2 + tool.open_m + context.fingers.thickness
    x, y, _ = (float(v) for v in place.position)
    over_middle = ToolPose(x, y, take.z, yaw - standing.askew)
    down = over_middle.at(z=max(lowest(context), fixture.tuck_down_m))
    allowed = in_ducts(context)
    is_taken = False
    with suppress(AbilityError):
        context.drive_fingers(tool.open_m)
        travel = motion.travel_z_m + fixture.tuck_over_travel_m
        yield from move_to(
            context, take.at(z=max(travel, context.commanded.z)), motion.free_speed_m_s
        )
        yield from move_to(context, take.at(z=travel), motion.free_speed_m_s)
        yield from move_to(context, take, motion.approach_speed_m_s, allowed)
        if is_beside and is_free(context, lower, AMONG_WIRES):
            yield from move_to(context, lower, motion.approach_speed_m_s, AMONG_WIRES)
        context.close_fingers(context.wire.diameter)
        yield from fingers_still(context)
        if not grips_nothing(context, context.wire.diameter):
            is_taken = True
            yield from _bring_down(context, take, over_middle, down)
    yield from withdraw(context, context.commanded)
    return is_taken


def _bring_down(context: RobotContext, *tools: ToolPose) -> Steps[None]:
    """Move a wire that is between the fingers, until it or what lies below it resists."""
    free = context.device.arm.force
    for tool in tools:
        for _ in move_to(
            context, tool, context.parameters.motion.leave_speed_m_s, in_ducts(context)
        ):
            yield
            if (
                float(np.linalg.norm(context.device.arm.force - free))
                > context.parameters.wire.tuck_most_n
            ):
                context.follow(context.device.arm.tool)
                return
