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
    eyelet_yaw,
    in_ducts,
    lowest,
    withdraw,
)
from remodel_skills.primitives.grasping import grips_nothing
from remodel_skills.primitives.motions import is_free, move_to, wait
from remodel_skills.primitives.observation.duct_check import Inspection, inspect_ducts
from remodel_skills.robot_context import RobotContext, Steps
from remodel_vision.laid_wire import Passing, uppermost_past
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Duct
from remodel_work.robot.arm import ToolPose


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
        yield from wait(context, tool.closing_s)
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
