"""Lay a wire into clips, or let it down into forks, as steps of an ability.

Clips, one after the other from the wire's fixed end on: the hand grips the wire behind the next
clip, swings it about the place where it is held last, and so brings it over the clip with little
slack; it presses it between the slopes from beside the clip, releases it, and presses it in from
above with closed fingers.

Forks between the wire's terminals: one end is fixed. The hand carries the other one high over the
forks, beyond its terminal, until the wire is nearly straight, and sinks with it:

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
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.grasping import (
    check_grip,
    grips_nothing,
    inside_terminal,
    open_fingers,
)
from remodel_skills.primitives.motions import (
    clear_hand,
    fingers_still,
    move_to,
    nearest_hand_yaw,
    rise,
    swing_to,
    wait,
)
from remodel_skills.primitives.observation.observing import go_and_see
from remodel_skills.primitives.observation.views import camera_above
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.laid_wire import WireLines, wire_around
from remodel_work.errors import AbilityError
from remodel_work.fixtures import SLOPE_ABOVE_LIPS_M, lip_top
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import Duct, PanelClip
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import opening_of, world_from_clip

WORTH_ANOTHER = frozenset({Code.GRASP_MISSED, Code.SNAGGED})


def lay_into(context: RobotContext, clip: PanelClip, held_at: Array) -> Steps[None]:
    """Bring the wire into a clip; what goes wrong is tried again.

    A wire that does not come along when it is lifted is held: by this clip, into which it may have
    snapped with the one before, or by what the observation from above will show.

    Args:
        context: the cell, its hand empty.
        clip: the next one along the wire.
        held_at: where the wire is held before it, (3,) [m], world frame.

    Raises:
        AbilityError: CABLE_NOT_FOUND, GRASP_MISSED, NOT_SEATED.
    """
    most, slack_m = context.parameters.motion.clip_attempts, context.parameters.fixture.clip_slack_m
    for attempt in range(1, most + 1):
        try:
            yield from _bring_into(context, clip, held_at, attempt * slack_m)
        except AbilityError as error:
            if error.code not in WORTH_ANOTHER:
                raise
            yield from clear_hand(context)
            if attempt < most:
                continue
            if error.code is not Code.SNAGGED:
                raise
        if (yield from press_from_above(context, clip)):
            return
    raise AbilityError(
        Code.NOT_SEATED,
        f"the wire does not go into clip {clip.id!r}, which takes {clip.retention_force:.1f} N; "
        "route it again",
    )


def _bring_into(
    context: RobotContext, clip: PanelClip, held_at: Array, slack: float
) -> Steps[None]:
    tool = context.parameters.tool
    beside = _beside(context, clip)
    grasp = yield from _find(context, clip, held_at, slack)
    free = context.device.arm.force
    yield from grip_from_above(context, grasp)
    for place in (grasp, beside):
        over = _lifted(context, place, held_at, _clear_height(context, clip))
        yield from carry(
            context,
            _tool(context, over, float(over.position[2])),
            context.parameters.motion.swing_speed_m_s,
            free,
            most=tool.grip_holds_n,
        )
    lowest = _tool(context, beside, context.fingers.below + tool.floor_clearance_m)
    yield from _press_to(context, lowest, _beside_force(context, clip))
    yield from open_fingers(context, tool.open_m)


def _beside(context: RobotContext, clip: PanelClip) -> Pose:
    """Return where the hand grips the wire for a clip, x along the wire, world frame."""
    return world_from_clip(clip, context.panel) @ Pose.level(_beside_clip(context, clip), 0.0, 0.0)


def _beside_clip(context: RobotContext, clip: PanelClip) -> float:
    """Return how far from a clip's middle the hand clears it along the wire [m]."""
    clear_m = context.parameters.tool.pads_clear_m
    return clip.length / 2 + (context.fingers.width / 2 + clear_m)


def _beside_force(context: RobotContext, clip: PanelClip) -> float:
    """Return the force with which a wire is pressed into a clip from beside it [N]."""
    return context.parameters.fixture.clip_beside_ratio * clip.retention_force


def _clear_height(context: RobotContext, clip: PanelClip) -> float:
    """Return the tool's height at which the pads and what they hold clear a clip [m]."""
    clear_m = context.parameters.fixture.clip_clear_m
    return lip_top(clip) + SLOPE_ABOVE_LIPS_M + context.fingers.below + clear_m


def _lifted(context: RobotContext, place: Pose, held_at: Array, height: float) -> Pose:
    """Return where a place of the wire comes to when it is lifted and keeps its distance.

    Args:
        context: the cell.
        place: of the wire, world frame.
        held_at: from which it keeps its distance, (3,) [m], world frame.
        height: of the tool [m].
    """
    out = (place.position - held_at)[:2]
    far = float(np.linalg.norm(out))
    rise = height + context.parameters.tool.wire_in_grip_m - held_at[2]
    x, y = held_at[:2] + out * math.sqrt(max(far**2 - rise**2, 0.0)) / far
    return Pose(np.array([x, y, height]), place.quaternion)


def _tool(context: RobotContext, place: Pose, z: float) -> ToolPose:
    x, y, _ = (float(v) for v in place.position)
    return ToolPose(
        x, y, z, nearest_hand_yaw(context.arm, x, y, place.yaw, near=context.commanded.yaw)
    )


def _find(context: RobotContext, clip: PanelClip, held_at: Array, slack: float) -> Steps[Pose]:
    """Find the wire from the hand, as far from where it is held as it will be at the clip."""
    beside = _beside(context, clip)
    away = (beside.position - held_at)[:2]
    radius = float(np.linalg.norm(away)) + slack
    towards = math.atan2(away[1], away[0])
    tool = camera_above(context, beside.position[:2], towards)
    picture = yield from go_and_see(context, tool)
    wire = context.wire
    turned = wire_around(held_at[:2], radius, towards, WireLines(picture, wire))
    drawing = Drawing(picture.rgb, picture.view)
    if turned is None:
        drawing.title(f"{wire.id} not seen before clip {clip.id}")
        context.cameras.show("wrist", picture, drawing.image)
        raise AbilityError(
            Code.CABLE_NOT_FOUND,
            f"{wire.id!r} is not seen {radius * 1e3:.0f} mm from where it is held last, before "
            f"clip {clip.id!r}; observe it, route it again",
        )
    yaw = towards + turned
    x, y = held_at[:2] + radius * np.array([math.cos(yaw), math.sin(yaw)])
    grasp = Pose.level(float(x), float(y), wire.radius, yaw)
    drawing.circle(picture.view.project(grasp.position)[0], 9, ORANGE)
    drawing.title(f"{wire.id} before clip {clip.id}")
    context.cameras.show("wrist", picture, drawing.image)
    return grasp


def grip_from_above(context: RobotContext, grasp: Pose) -> Steps[None]:
    """Close the fingers on the wire where it lies, low between the pads; raises GRASP_MISSED."""
    rises_m, motion = context.parameters.fixture.clip_rises_m, context.parameters.motion
    hand = context.parameters.tool
    tool = _tool(context, grasp, context.fingers.below + hand.floor_clearance_m)
    yield from clear_hand(context)
    yield from move_to(context, tool.at(z=context.commanded.z), motion.free_speed_m_s)
    context.drive_fingers(hand.open_m)
    for above in rises_m:
        yield from move_to(context, tool.at(z=tool.z + above), motion.approach_speed_m_s)
        context.drive_fingers(0.0)
        yield from fingers_still(context)
        if not grips_nothing(context, context.wire.diameter):
            return
        context.drive_fingers(hand.open_m)
        yield from fingers_still(context)
    yield from clear_hand(context)
    raise AbilityError(
        Code.GRASP_MISSED,
        f"the fingers found no {context.wire.id!r} between the plate and "
        f"{(rises_m[0] + context.fingers.pad_height) * 1e3:.0f} mm above it; route it again",
    )


def _press_to(context: RobotContext, bottom: ToolPose, limit: float) -> Steps[bool]:
    """Go down to a tool pose, or until it takes so much force [N]; return whether it got there."""
    pace, within_m = context.parameters.motion, context.parameters.fixture.clip_lips_within_m
    yield from wait(context, pace.force_still_s)
    way = bottom.position - context.commanded.position
    length = float(np.linalg.norm(way))
    motion = ForceMotion(context, way / length, limit, free=context.device.arm.force)
    while not motion.met_limit and motion.travel < length - pace.arrived_m:
        left = length - motion.travel
        speed = pace.press_speed_m_s if left > within_m else pace.lips_speed_m_s
        yield from motion.advance(min(speed, left / context.tick_s))
    motion.stop()
    return motion.travel >= length - pace.arrived_m


def press_from_above(context: RobotContext, clip: PanelClip) -> Steps[bool]:
    """Press the wire between the lips with closed fingers; return whether they come down there."""
    fixture = context.parameters.fixture
    bottom = lip_top(clip) + fixture.clip_above_lips_m
    return (
        yield from _press_at(
            context, clip, 0.0, bottom, fixture.clip_excess_ratio * clip.retention_force
        )
    )


def press_around(context: RobotContext, clip: PanelClip) -> Steps[None]:
    """Press a wire that stands off its clip between the lips, and down beside both ends.

    The fingers come no deeper than the lips' top, where a wire may stick between them: bent down
    beside them it is drawn in. What comes down at one side may rise at the other one.
    """
    yield from press_from_above(context, clip)
    out, lowest_m = _beside_clip(context, clip), context.parameters.tool.floor_clearance_m
    for along in (-out, out):
        yield from _press_at(context, clip, along, lowest_m, _beside_force(context, clip))
    yield from press_from_above(context, clip)


def _press_at(
    context: RobotContext, clip: PanelClip, along: float, bottom: float, limit: float
) -> Steps[bool]:
    """Press on the wire with closed fingers; return whether their tips come down to the bottom.

    Args:
        context: the cell, its hand empty.
        clip: that the wire is pressed into.
        along: from the clip's middle, along the wire [m].
        bottom: above the plate [m].
        limit: of the force [N].
    """
    motion = context.parameters.motion
    place = world_from_clip(clip, context.panel) @ Pose.level(along, 0.0, 0.0)
    above = _tool(
        context, place, _clear_height(context, clip) + context.parameters.fixture.clip_above_wire_m
    )
    yield from rise(context)
    context.drive_fingers(0.0)
    yield from swing_to(context, above.at(z=context.commanded.z))
    yield from move_to(context, above, motion.approach_speed_m_s)
    yield from fingers_still(context)
    arrived = yield from _press_to(context, above.at(z=bottom + context.fingers.below), limit)
    yield from move_to(context, above, motion.approach_speed_m_s)
    return arrived


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
    yield from carry(context, _raised(context, fixed, high, length), motion.carry_speed_m_s, free)
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


def _raised(context: RobotContext, fixed: Array, high: float, length: float) -> ToolPose:
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
