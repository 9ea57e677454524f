"""RouteWire: carry the held end along a path, or lay the wire into the clips on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import BeliefState, EndState, Grip
from remodel_skills.goal_checks import (
    Message,
    check_held,
    check_live,
    check_tool_path,
    pose_from,
    require,
    require_level,
    require_pose,
    require_robot,
)
from remodel_skills.parameters import Parameters
from remodel_skills.primitives.carrying import carry, lay_down
from remodel_skills.primitives.clips_and_forks import lay_into, let_into_forks, press_around
from remodel_skills.primitives.grasping import check_grip
from remodel_skills.primitives.motions import disengage, held_tool
from remodel_skills.primitives.observation.checks import (
    check_path_in_ducts,
    clip_fault,
    duct_places,
    judge_clips,
    observe_route,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Panel, PanelClip
from remodel_work.routes import clips_along, opening_of, world_from_clip


@dataclass(frozen=True)
class RouteGoal:
    """Carry the held end along poses of the tool centre, x along the wire towards the tip.

    Or lay the wire into the clips that the path passes.
    """

    robot_name: str
    cable_id: str
    path: tuple[Pose, ...]

    def __post_init__(self) -> None:
        """Refuse unknown robots, an empty path and poses that are none."""
        require_robot(self.robot_name)
        require(bool(self.path), "path is empty; it must have one pose or more")
        for i, pose in enumerate(self.path):
            require_pose(f"path[{i}]", pose)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or a pose is not level or out of reach."""
        for i, pose in enumerate(self.path):
            require_level(f"path[{i}]", pose, parameters.terminal.level_rad)
        check_live(self.cable_id, panel, belief)
        check_held(belief)
        check_tool_path(self.path, belief)
        clips = clips_along(self.path, panel)
        if (
            clips
            and belief.grip is not None
            and belief.ends[belief.grip.end.other] is EndState.LOOSE
        ):
            other = belief.grip.end.other.value
            raise AbilityError(
                Code.INVALID_GOAL,
                f"the path passes clips {', '.join(clip.id for clip in clips)}, and end {other} of "
                f"{self.cable_id!r} is loose; insert and fix it first",
            )


@dataclass(frozen=True)
class WireRouted:
    """A wire carried along.

    Attributes:
        message: for a person.
        reached: number of path poses reached.
    """

    message: str
    reached: int


def _goal(message: Message, board: Pose) -> RouteGoal:
    return RouteGoal(
        message.robot_name,
        message.cable_id,
        tuple(pose_from(f"path[{i}]", p, board) for i, p in enumerate(message.path)),
    )


@ability("RouteWire", _goal)
def route_wire(context: RobotContext, goal: RouteGoal) -> Steps[WireRouted]:
    """Go from pose to pose with the end; lay the wire into the clips or forks that the path passes.

    Whether it lies in clips and ducts is seen from above; in forks it still moves until FixCable
    has fixed its end. The end stays in the hand, or lies loose when there are clips.
    """
    yield from disengage(context)
    clips = clips_along(goal.path, context.panel)
    forks = [duct for duct in duct_places(context, goal.path) if duct.is_fork]
    if clips:
        yield from _lay_into_all(context, clips)
    elif forks and context.belief.by_magazine:
        context.report("letting the wire down into its forks", 0.1)
        yield from let_into_forks(context, forks)
    else:
        yield from _carry_along(context, goal)
    count = len(goal.path)
    try:
        yield from check_path_in_ducts(context, goal.path)
    except AbilityError as error:
        error.found["reached"] = count
        raise
    holders = [*(clip.id for clip in clips), *(fork.id for fork in forks)]
    done = f"laid into {', '.join(holders)}" if holders else f"carried along {count} poses"
    return WireRouted(f"{goal.cable_id} {done}", count)


def _carry_along(context: RobotContext, goal: RouteGoal) -> Steps[None]:
    """Lift to the first pose's height, then go from pose to pose in straight lines."""
    motion = context.parameters.motion
    count, free = len(goal.path), context.device.arm.force
    for i, pose in enumerate(goal.path):
        context.report(f"carrying the wire to pose {i + 1} of {count}", 0.95 * i / count)
        tool = held_tool(context, pose)
        try:
            if i == 0 and tool.z > context.commanded.z:
                yield from carry(
                    context, context.commanded.at(z=tool.z), motion.carry_speed_m_s, free
                )
            yield from carry(context, tool, motion.carry_speed_m_s, free)
            check_grip(context)
        except AbilityError as error:
            error.found["reached"] = i
            raise


def _lay_into_all(context: RobotContext, clips: tuple[PanelClip, ...]) -> Steps[None]:
    """Lay the end down where it was picked, and the wire into its clips, one by one."""
    grip = check_held(context.belief)
    held_at = _held_at(context, grip)
    yield from lay_down(context, context.belief.picked_at[grip.end].tool, (0.0, 0.05), fork=False)
    for i, clip in enumerate(clips):
        context.report(f"laying the wire into clip {clip.id}", 0.05 + 0.8 * i / len(clips))
        yield from lay_into(context, clip, held_at)
        held_at = world_from_clip(clip, context.panel).apply(np.array([0.0, 0.0, clip.height]))
        context.belief.in_clips.append(held_at)
    context.report("observing the clips from above", 0.85)
    at = np.array([world_from_clip(clip, context.panel).position for clip in clips])
    seen = yield from observe_route(context, at)
    for _ in range(context.parameters.motion.clip_presses):
        standing_off = [
            clip
            for clip in clips
            if clip_fault(clip, seen, context.panel, context.parameters.looking)
        ]
        if not standing_off:
            break
        for clip in standing_off:
            yield from press_around(context, clip)
        seen = yield from observe_route(context, at)
    judge_clips(context, clips, seen)


def _held_at(context: RobotContext, grip: Grip) -> Array:
    """Return where the wire is held nearest to the held end, (3,) [m], world frame."""
    if context.belief.in_clips:
        return context.belief.in_clips[-1]
    terminal = context.wire.goes_to(grip.end.other)
    return opening_of(terminal, context.panel, context.belief.seen).position
