"""Clear the overhead camera's view of some places, while another robot stays where it is."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from remodel_skills.primitives.motions import FREE_SPEED, move_to, rise
from remodel_skills.robot_context import RobotContext, Steps
from remodel_skills.traffic import MARGIN_M
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import Volume, gap_between, volume_of

# A line of sight is free if nothing is nearer to it [m].
SIGHT_RADIUS_M = 0.015
# An empty hand goes so high, and so far aside of the places that are to be seen.
ASIDE_Z = 0.30
ASIDE_M = (0.20, 0.30, 0.40, 0.50, 0.60)
DIRECTIONS = 8


def clear_sight(context: RobotContext, points: Array) -> Steps[None]:
    """Move the empty hand out of the overhead camera's lines of sight to points (n, 3) [m].

    Raises:
        AbilityError: UNREACHABLE when no place was found.
    """
    if _sees_past(context, context.commanded, points):
        return
    yield from rise(context, ASIDE_Z)
    for place in _aside(context, points):
        if _sees_past(context, place, points) and _has_room(context, place):
            try:
                yield from move_to(context, place, FREE_SPEED)
            except AbilityError as error:
                if error.code is not Code.UNREACHABLE:
                    raise
            else:
                return
    raise AbilityError(
        Code.UNREACHABLE,
        f"{context.name} finds no place from which it does not hide the board from the overhead "
        f"camera; it stands at {context.commanded}",
    )


def _aside(context: RobotContext, points: Array) -> Iterator[ToolPose]:
    """Yield tool poses beside points that the robot reaches, the nearest first."""
    now, middle = context.commanded, points.mean(axis=0)
    reach = float(np.linalg.norm((points - middle)[:, :2], axis=1).max())
    for away in ASIDE_M:
        for angle in np.arange(DIRECTIONS) * (2 * math.pi / DIRECTIONS):
            x = float(middle[0] + (reach + away) * math.cos(angle))
            y = float(middle[1] + (reach + away) * math.sin(angle))
            place = ToolPose(x, y, max(ASIDE_Z, now.z), now.yaw)
            if context.arm.reaches(place):
                yield place


def _sees_past(context: RobotContext, place: ToolPose, points: Array) -> bool:
    eye = context.cameras.overhead_view.world_from_camera.position
    lines = Volume(np.tile(eye, (len(points), 1)), points, np.full(len(points), SIGHT_RADIUS_M))
    return gap_between(volume_of(context.arm, context.arm.joints_for(place)), lines) > 0


def _has_room(context: RobotContext, place: ToolPose) -> bool:
    here = volume_of(context.arm, context.arm.joints_for(place))
    others = [volume_of(c.arm, c.arm.joints_for(c.commanded)) for c in context.peers]
    return all(gap_between(here, other) > MARGIN_M for other in others)
