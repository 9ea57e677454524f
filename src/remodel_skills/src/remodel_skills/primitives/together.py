"""Robots that hold the same wire move together; several steps run at once."""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from remodel_skills.motion import Line
from remodel_skills.primitives.motions import (
    NOTHING,
    check_lag,
    check_tracking,
    straight_line,
    wait_to_follow,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import gap_between, volume_of


def move_together(
    targets: Sequence[tuple[RobotContext, ToolPose]],
    speed: float,
    others: float | None = None,
    allowed: Set[str] = NOTHING,
) -> Steps[None]:
    """Move all tools in straight lines that begin and end at the same time.

    So the distance between two of them is never more than at the start or at the end, and the wire
    between them is never pulled taut on the way.

    Args:
        targets: the robots, each with where its tool goes.
        speed: that no tool centre exceeds, or only the first one's [m/s].
        others: the same of the other ones [m/s]; None: as of the first.
        allowed: names of obstacles that the first one may touch.

    Raises:
        AbilityError: UNREACHABLE before anything moves, MOTION_FAULT when a robot does not arrive.
    """
    speeds = [speed, *[speed if others is None else others] * (len(targets) - 1)]
    touchable = [allowed, *[NOTHING] * (len(targets) - 1)]
    lines = [
        straight_line(context, target, most, may_touch)
        for (context, target), most, may_touch in zip(targets, speeds, touchable, strict=True)
    ]
    duration = max(line.duration for line in lines)
    contexts = [context for context, _ in targets]
    moves = [(c, replace(line, least_s=duration)) for c, line in zip(contexts, lines, strict=True)]
    _check_apart(moves)
    for context, line in moves:
        context.space.take(line.postures(context.arm))
    tick_s = contexts[0].tick_s
    for tick in range(1, math.ceil(duration / tick_s) + 1):
        for context, line in moves:
            context.follow(line.at(tick * tick_s))
        yield
        for context, line in moves:
            check_lag(context, line.at((tick - context.lead_ticks) * tick_s))
    for context, line in moves:
        context.follow(line.end)
    yield from wait_to_follow(contexts[0])
    for context in contexts:
        context.space.stand(context.commanded)
        check_tracking(context)


def _check_apart(moves: Sequence[tuple[RobotContext, Line]]) -> None:
    """Raise UNREACHABLE when two robots would come too near to each other on the way."""
    gap, margin_m = least_gap(moves), moves[0][0].parameters.motion.robots_apart_m
    if gap < margin_m:
        names = " and ".join(context.name for context, _ in moves)
        raise AbilityError(
            Code.UNREACHABLE,
            f"{names} would come within {gap * 1e3:.0f} mm of each other on the way to "
            f"{moves[0][1].end}; allowed: {margin_m * 1e3:.0f} mm or more",
        )


def least_gap(moves: Sequence[tuple[RobotContext, Line]]) -> float:
    """Return the least distance between robots that move along lines at the same time [m].

    Raises:
        AbilityError: UNREACHABLE when a robot does not reach a place on its line.
    """
    step_m = moves[0][0].parameters.motion.check_step_m
    farthest = max(line.distance for _, line in moves)
    shares = np.linspace(0.0, 1.0, max(3, math.ceil(farthest / step_m) + 1))
    least = math.inf
    for (one, first), (other, second) in combinations(moves, 2):
        for share in shares:
            volumes = [
                volume_of(context.arm, context.arm.joints_for(line.between(share)))
                for context, line in ((one, first), (other, second))
            ]
            least = min(least, gap_between(*volumes))
    return least


def concurrently(*all_steps: Steps[Any]) -> Steps[tuple[Any, ...]]:
    """Do one step of each per tick, until the last is done; return what each returns.

    When one of them raises, the others are stopped where they are.
    """
    results: dict[int, Any] = {}
    pending = dict(enumerate(all_steps))
    try:
        while pending:
            for i, steps in tuple(pending.items()):
                try:
                    next(steps)
                except StopIteration as done:
                    results[i] = done.value
                    del pending[i]
            if pending:
                yield
    finally:
        for steps in pending.values():
            steps.close()
    return tuple(results[i] for i in range(len(all_steps)))
