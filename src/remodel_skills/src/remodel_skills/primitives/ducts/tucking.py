"""Tuck a wire into its ducts where it stands out of them, as steps of an ability.

Inserting its second end pushes a wire's excess length back into the ducts, and a stiff wire arches
out of them. Taken where it stands out, and brought down between the walls, it bends into a loop at
its slot instead, and stays.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from remodel_skills.primitives.ducts.leading import (
    AMONG_WIRES,
    LEAVE_SPEED,
    eyelet_yaw,
    in_ducts,
    lowest,
    withdraw,
)
from remodel_skills.primitives.grasping import grips_nothing
from remodel_skills.primitives.motions import (
    APPROACH_SPEED,
    FREE_SPEED,
    HAND_OPEN_M,
    TRAVEL_Z,
    is_free,
    move_to,
    wait,
)
from remodel_skills.primitives.observation.duct_check import (
    LEAST_IN_DUCTS,
    Inspection,
    inspect_ducts,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_vision.laid_wire import Passing, uppermost_past
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Duct
from remodel_work.robot.arm import ToolPose

# A wire that lies in its ducts at so much of its route is left alone; it is tucked in so often, and
# so often while the inspection would refuse it.
ENOUGH_IN_DUCTS = 0.95
TUCKS = 3
TUCKS_OF_REFUSED = 8
# Its loop stands so far to each side of a slot: pressed down there it would spring back. The hand
# has room between the walls so far from a corner [m].
LOOP_M = 0.060
CORNER_M = 0.035
# It is searched for so far to each side of a duct's middle [m].
REACH_M = 0.050
# Its direction is taken over so much to each side [m].
DIRECTION_M = 0.012
# The fingertips stay so far above the walls, and take a wire that is so much higher [m].
OVER_RIM_M = 0.001
GRASPABLE_M = 0.002
# The wire is brought down to this height [m].
DOWN_M = 0.012
# It and the wires below it may resist with so much [N].
MOST_N = 15.0
CLOSE_S = 0.4
# The hand comes from so far above where it travels: a loop may stand there [m].
OVER_TRAVEL_M = 0.030


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
    tucks: Counter[str] = Counter()  # in each duct
    is_taken = True

    def order(at: Standing) -> tuple[int, float]:
        return tucks[at.duct.id], -at.passing.height

    found = yield from inspect_ducts(context)
    while found is not None and tucks.total() < TUCKS_OF_REFUSED:
        goes_on = is_taken and tucks.total() < TUCKS
        best = min(_standing(found), key=order, default=None)
        if best is None or found.share >= (ENOUGH_IN_DUCTS if goes_on else LEAST_IN_DUCTS):
            break
        tucks[best.duct.id] += 1
        is_taken = yield from _tuck(context, best)
        found = yield from inspect_ducts(context)
    return found


def _standing(found: Inspection) -> Iterator[Standing]:
    """Yield where a wire stands above a duct, and a hand has room to tuck it in."""
    _, first, *corners, last, _ = (point[:2] for point in found.route)
    rooms = [(slot, LOOP_M) for slot in (first, last)] + [(corner, CORNER_M) for corner in corners]
    for duct, places in found.places.items():
        for place in places:
            here = place.position
            if any(float(np.linalg.norm(here[:2] - point)) < room for point, room in rooms):
                continue
            at_rim = place @ Pose.level(0.0, 0.0, duct.height - float(here[2]))
            behind, passing, beyond = (
                uppermost_past(at_rim @ Pose.level(x, 0.0, 0.0), REACH_M, found.seen, found.before)
                for x in (-DIRECTION_M, 0.0, DIRECTION_M)
            )
            if passing is None or passing.height < duct.height + GRASPABLE_M:
                continue
            askew = 0.0
            if behind is not None and beyond is not None:
                askew = math.atan2(beyond.aside - behind.aside, 2 * DIRECTION_M)
            yield Standing(duct, at_rim, passing, askew)


def _tuck(context: RobotContext, standing: Standing) -> Steps[bool]:
    """Take a wire where it stands, and bring it down between the walls.

    Returns:
        Whether it was between the fingers.
    """
    duct, place, passing = standing.duct, standing.place, standing.passing
    context.report(f"tucking the wire into duct {duct.id!r}", 0.96)
    yaw = eyelet_yaw(context, [place.yaw + standing.askew, place.yaw])
    x, y, _ = (float(v) for v in place.apply(np.array([0.0, passing.aside, 0.0])))
    over = duct.height + OVER_RIM_M + context.fingers.below
    take = ToolPose(x, y, max(over, passing.height), yaw)
    # Over a wall the fingers would close on it there.
    lower = take.at(z=passing.height)
    is_beside = abs(passing.aside) >= duct.width / 2 + HAND_OPEN_M + context.fingers.thickness
    x, y, _ = (float(v) for v in place.position)
    over_middle = ToolPose(x, y, take.z, yaw - standing.askew)
    down = over_middle.at(z=max(lowest(context), DOWN_M))
    allowed = in_ducts(context)
    is_taken = False
    with suppress(AbilityError):
        context.drive_fingers(HAND_OPEN_M)
        travel = TRAVEL_Z + OVER_TRAVEL_M
        yield from move_to(context, take.at(z=max(travel, context.commanded.z)), FREE_SPEED)
        yield from move_to(context, take.at(z=travel), FREE_SPEED)
        yield from move_to(context, take, APPROACH_SPEED, allowed)
        if is_beside and is_free(context, lower, AMONG_WIRES):
            yield from move_to(context, lower, APPROACH_SPEED, AMONG_WIRES)
        context.close_fingers(context.wire.diameter)
        yield from wait(context, CLOSE_S)
        if not grips_nothing(context.device.gripper.gap, context.wire.diameter):
            is_taken = True
            yield from _bring_down(context, take, over_middle, down)
    yield from withdraw(context, context.commanded)
    return is_taken


def _bring_down(context: RobotContext, *tools: ToolPose) -> Steps[None]:
    """Move a wire that is between the fingers, until it or what lies below it resists."""
    free = context.device.arm.force
    for tool in tools:
        for _ in move_to(context, tool, LEAVE_SPEED, in_ducts(context)):
            yield
            if float(np.linalg.norm(context.device.arm.force - free)) > MOST_N:
                context.follow(context.device.arm.tool)
                return
