"""Let a wire down into the forks between its terminals, as steps of an ability.

One end is fixed. The hand carries the other one high over the forks, beyond its terminal, until the
wire is nearly straight, and sinks with it:

                                 ____----o  over the posts, beyond the terminal
                     ____----|
         ____----|           |
    [a]--        |           |  [b]
    _____________|___________|______

Close above the terminal's component the wire is between the posts. Then the hand goes back and down
in front of the terminal; the wire sags, and cannot leave its forks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from remodel_skills.belief_state import EndState, Grip
from remodel_skills.primitives.carrying import carry
from remodel_skills.primitives.grasping import check_grip
from remodel_skills.primitives.motions import APPROACH_SPEED, CARRY_SPEED
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, wrap_angle
from remodel_work.layout import STANDOFF_M
from remodel_work.openings import opening_of
from remodel_work.panel import Duct, Panel
from remodel_work.robot.arm import ToolPose

# The hand is so far from the fixed end, as a share of the wire between them: it pulls at neither,
# and the wire bows aside by 25 mm at most, less than half a fork.
STRAIGHT = 0.993
# Before that it is lifted until it is so far away, at most.
LIFTED = 0.90
# Where the wire crosses the posts it is so far above them; the hand is no higher than that [m].
OVER_POSTS_M = 0.020
HIGHEST_M = 0.30
# The wire sinks in steps no longer than this [m].
SINK_M = 0.030
# The fingertips go down to so far above the component of their terminal [m].
OVER_COMPONENT_M = 0.006
# So much of the wire is inside its terminal, about [m].
INSIDE_M = 0.014


def let_into_forks(context: RobotContext, forks: Iterable[Duct]) -> Steps[None]:
    """Let the wire down into its forks, and the held end down in front of its terminal.

    Raises:
        AbilityError: INVALID_GOAL when the other end is not fixed, SNAGGED when the wire pulls.
    """
    grip = _fixed_grip(context)
    start, own = (
        opening_of(context.wire.goes_to(end), context.panel, context.belief.seen)
        for end in (grip.end.other, grip.end)
    )
    before = tool_before(own, grip, -STANDOFF_M)
    free, fixed = context.device.arm.force, start.position
    length = context.wire.length - grip.distance - INSIDE_M
    away = before.position[:2] - fixed[:2]
    towards = away / np.linalg.norm(away)
    # The hand points along the wire.
    turn = wrap_angle(math.atan2(towards[1], towards[0]) - own.yaw)
    along = replace(before, yaw=before.yaw + float(turn))
    component = context.panel.component(context.wire.goes_to(grip.end)[0])
    low = component.size[2] + context.fingers.below + OVER_COMPONENT_M
    high = max(low, _over_posts(context.panel, forks, fixed, towards, length))
    yield from carry(context, _lifted(context, fixed, high, length), CARRY_SPEED, free)
    for height in np.linspace(high, low, math.ceil((high - low) / SINK_M) + 1):
        level = math.sqrt((STRAIGHT * length) ** 2 - (float(height) - fixed[2]) ** 2)
        x, y = (float(v) for v in fixed[:2] + level * towards)
        yield from carry(context, replace(along, x=x, y=y, z=float(height)), CARRY_SPEED, free)
        check_grip(context)
    yield from carry(context, before.at(z=low), APPROACH_SPEED, free)
    yield from carry(context, before, APPROACH_SPEED, free)
    check_grip(context)


def _lifted(context: RobotContext, fixed: Array, high: float, length: float) -> ToolPose:
    """Return the tool pose straight above, as high as the wire lets it go."""
    here = context.commanded
    level = float(np.linalg.norm(here.position[:2] - fixed[:2]))
    rise = math.sqrt(max(0.0, (LIFTED * length) ** 2 - level**2))
    return here.at(z=max(here.z, min(high, float(fixed[2]) + rise)))


def _fixed_grip(context: RobotContext) -> Grip:
    grip = context.belief.grip
    if grip is None:
        raise AbilityError(Code.NOTHING_HELD, "the gripper is empty; pick the wire first")
    if context.belief.ends[grip.end.other] is not EndState.FIXED:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"end {grip.end.other.value} of {context.wire.id!r} is not fixed: the wire cannot be "
            "drawn straight over forks; insert and fix that end first",
        )
    return grip


def _over_posts(
    panel: Panel, forks: Iterable[Duct], fixed: Array, towards: Array, length: float
) -> float:
    """Return the height of the tool at which a straight wire clears all posts [m]."""
    highest = 0.0
    for fork in forks:
        place = panel.world_from_panel.apply(np.array([*fork.pose[:2], 0.0]))
        along = float((place[:2] - fixed[:2]) @ towards)
        if along > 0:
            rise = max(0.0, fork.height + OVER_POSTS_M - float(fixed[2]))
            highest = max(highest, float(fixed[2]) + rise * length / along)
    return min(highest, HIGHEST_M)
