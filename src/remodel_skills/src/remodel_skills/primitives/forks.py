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
from remodel_skills.goal_checks import check_held
from remodel_skills.primitives.carrying import carry
from remodel_skills.primitives.grasping import check_grip, inside_terminal
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, wrap_angle
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import Duct
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import opening_of


def let_into_forks(context: RobotContext, forks: Iterable[Duct]) -> Steps[None]:
    """Let the wire down into its forks, and the held end down in front of its terminal.

    Raises:
        AbilityError: INVALID_GOAL when the other end is not fixed, SNAGGED when the wire pulls.
    """
    fixture, motion = context.parameters.fixture, context.parameters.motion
    grip = _fixed_grip(context)
    start, own = (
        opening_of(context.wire.goes_to(end), context.panel, context.belief.seen)
        for end in (grip.end.other, grip.end)
    )
    before = tool_before(own, grip, -STANDOFF_M)
    free, fixed = context.device.arm.force, start.position
    length = context.wire.length - grip.distance - inside_terminal(context, grip.end.other)
    away = before.position[:2] - fixed[:2]
    towards = away / np.linalg.norm(away)
    # The hand points along the wire.
    turn = wrap_angle(math.atan2(towards[1], towards[0]) - own.yaw)
    along = replace(before, yaw=before.yaw + float(turn))
    component = context.panel.component(context.wire.goes_to(grip.end)[0])
    low = component.size[2] + context.fingers.below + fixture.fork_over_component_m
    high = max(low, _over_posts(context, forks, fixed, towards, length))
    yield from carry(context, _lifted(context, fixed, high, length), motion.carry_speed_m_s, free)
    for height in np.linspace(high, low, math.ceil((high - low) / fixture.fork_sink_m) + 1):
        level = math.sqrt(
            (context.parameters.wire.straight_share * length) ** 2 - (float(height) - fixed[2]) ** 2
        )
        x, y = (float(v) for v in fixed[:2] + level * towards)
        yield from carry(
            context, replace(along, x=x, y=y, z=float(height)), motion.carry_speed_m_s, free
        )
        check_grip(context)
    yield from carry(context, before.at(z=low), motion.approach_speed_m_s, free)
    yield from carry(context, before, motion.approach_speed_m_s, free)
    check_grip(context)


def _lifted(context: RobotContext, fixed: Array, high: float, length: float) -> ToolPose:
    """Return the tool pose straight above, as high as the wire lets it go."""
    here = context.commanded
    level = float(np.linalg.norm(here.position[:2] - fixed[:2]))
    rise = math.sqrt(max(0.0, (context.parameters.wire.lifted_share * length) ** 2 - level**2))
    return here.at(z=max(here.z, min(high, float(fixed[2]) + rise)))


def _fixed_grip(context: RobotContext) -> Grip:
    grip = check_held(context.belief)
    if context.belief.ends[grip.end.other] is not EndState.FIXED:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"end {grip.end.other.value} of {context.wire.id!r} is not fixed: the wire cannot be "
            "drawn straight over forks; insert and fix that end first",
        )
    return grip


def _over_posts(
    context: RobotContext, forks: Iterable[Duct], fixed: Array, towards: Array, length: float
) -> float:
    """Return the height of the tool at which a straight wire clears all posts [m]."""
    highest, fixture = 0.0, context.parameters.fixture
    for fork in forks:
        place = context.panel.world_from_panel.apply(np.array([*fork.pose[:2], 0.0]))
        along = float((place[:2] - fixed[:2]) @ towards)
        if along > 0:
            rise = max(0.0, fork.height + fixture.fork_over_posts_m - float(fixed[2]))
            highest = max(highest, float(fixed[2]) + rise * length / along)
    return min(highest, fixture.fork_highest_m)
