"""Lay a wire into clips, one after the other from its fixed end on, as steps of an ability.

The hand grips the wire behind the next clip, swings it about the place where it is held last, and
so brings it over the clip with little slack; it presses it between the slopes from beside the clip,
releases it, and presses it in from above with closed fingers.
"""

from __future__ import annotations

import math

import numpy as np

from remodel_skills.force_control import ForceControl
from remodel_skills.primitives.carrying import carry
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.grasping import FLOOR_CLEARANCE_M, OPEN_SPEED, grips_nothing
from remodel_skills.primitives.motions import (
    APPROACH_SPEED,
    FREE_SPEED,
    HAND_OPEN_M,
    clear_hand,
    move_to,
    nearest_hand_yaw,
    rise,
    swing_to,
    wait,
)
from remodel_skills.primitives.observation.observing import go_and_see
from remodel_skills.primitives.observation.views import camera_above
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.drawing import ORANGE, Drawing
from remodel_vision.laid_wire import wire_around
from remodel_vision.wire_lines import WireLines
from remodel_work.errors import AbilityError
from remodel_work.fixtures import SLOPE_ABOVE_LIPS_M, lip_top
from remodel_work.geometry import Array, Pose
from remodel_work.panel import PanelClip
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import world_from_clip

# The pads clear the clip's slopes by so much along the wire.
CLEAR_OF_SLOPES_M = 0.007
# The swing leaves so much slack, and as much more in each further attempt.
SLACK_M = 0.0015
# The wire lies so high in the grip, above the tool centre, more or less.
IN_GRIP_M = -0.001
# Held this far above a clip, a wire clears it.
CLEAR_M = 0.005
# The fingers clear a wire that stands off its clips by so much.
ABOVE_WIRE_M = 0.010
# The grip bends the wire a little where it lies; that may pull with so much.
MAX_PULL_N = 25.0
SWING_SPEED = 0.15  # [m/s] with the wire in the grip
PRESS_SPEED = 0.030
# Near the lips slower: they let the wire go suddenly, and the pads meet them.
LIPS_WITHIN_M = 0.008
LIPS_SPEED = 0.006
# From beside, the wire is pressed with so many times the clip's force.
ENOUGH = 2.0
# The fingers come so near to the lips; the wire's middle is then below the lips' [m].
ABOVE_LIPS_M = 0.00015
# A wire that takes more than so many times the clip's force does not go in.
EXCESS = 2.5
# A wire between two clips may hang in the air. The fingers close at these heights above the plate,
# the highest first: so the wire lies low between the pads, and they press it down below the lips.
RISES_M = (0.020, 0.016, 0.012, 0.008, 0.004, 0.0)
OPEN_S = 0.2
STILL_S = 0.10
ATTEMPTS = 3
WORTH_ANOTHER = frozenset({Code.GRASP_MISSED, Code.SNAGGED})
CLOSE_S = 0.6
REST_M = 1e-5


def lay_into(context: RobotContext, clip: PanelClip, held_at: Array) -> Steps[None]:
    """Bring the wire into a clip; what goes wrong is tried again, ATTEMPTS times in all.

    A wire that does not come along when it is lifted is held: by this clip, into which it may have
    snapped with the one before, or by what the observation from above will show.

    Args:
        context: the cell, its hand empty.
        clip: the next one along the wire.
        held_at: where the wire is held before it, (3,) [m], world frame.

    Raises:
        AbilityError: CABLE_NOT_FOUND, GRASP_MISSED, NOT_SEATED.
    """
    for attempt in range(1, ATTEMPTS + 1):
        try:
            yield from _bring_into(context, clip, held_at, attempt * SLACK_M)
        except AbilityError as error:
            if error.code not in WORTH_ANOTHER:
                raise
            yield from clear_hand(context)
            if attempt < ATTEMPTS:
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
    beside = _beside(context, clip)
    grasp = yield from _find(context, clip, held_at, slack)
    free = context.device.arm.force
    yield from grip_from_above(context, grasp)
    for place in (grasp, beside):
        over = _lifted(place, held_at, _clear_height(context, clip))
        yield from carry(
            context,
            _tool(context, over, float(over.position[2])),
            SWING_SPEED,
            free,
            most=MAX_PULL_N,
        )
    lowest = _tool(context, beside, context.fingers.below + FLOOR_CLEARANCE_M)
    yield from _press_to(context, lowest, ENOUGH * clip.retention_force)
    yield from _release(context)


def _beside(context: RobotContext, clip: PanelClip) -> Pose:
    """Return where the hand grips the wire for a clip, x along the wire, world frame."""
    return world_from_clip(clip, context.panel) @ Pose.level(_beside_clip(context, clip), 0.0, 0.0)


def _beside_clip(context: RobotContext, clip: PanelClip) -> float:
    """Return how far from a clip's middle the hand clears it along the wire [m]."""
    return clip.length / 2 + (context.fingers.width / 2 + CLEAR_OF_SLOPES_M)


def _clear_height(context: RobotContext, clip: PanelClip) -> float:
    """Return the tool's height at which the pads and what they hold clear a clip [m]."""
    return lip_top(clip) + SLOPE_ABOVE_LIPS_M + context.fingers.below + CLEAR_M


def _lifted(place: Pose, held_at: Array, height: float) -> Pose:
    """Return where a place of the wire comes to when it is lifted and keeps its distance.

    Args:
        place: of the wire, world frame.
        held_at: from which it keeps its distance, (3,) [m], world frame.
        height: of the tool [m].
    """
    out = (place.position - held_at)[:2]
    far = float(np.linalg.norm(out))
    rise = height + IN_GRIP_M - held_at[2]
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
    tool = _tool(context, grasp, context.fingers.below + FLOOR_CLEARANCE_M)
    yield from clear_hand(context)
    yield from move_to(context, tool.at(z=context.commanded.z), FREE_SPEED)
    context.drive_fingers(HAND_OPEN_M)
    for above in RISES_M:
        yield from move_to(context, tool.at(z=tool.z + above), APPROACH_SPEED)
        context.drive_fingers(0.0)
        yield from _fingers_still(context)
        if not grips_nothing(context.device.gripper.gap, context.wire.diameter):
            return
        context.drive_fingers(HAND_OPEN_M)
        yield from wait(context, OPEN_S)
    yield from clear_hand(context)
    raise AbilityError(
        Code.GRASP_MISSED,
        f"the fingers found no {context.wire.id!r} between the plate and "
        f"{(RISES_M[0] + context.fingers.pad_height) * 1e3:.0f} mm above it; route it again",
    )


def _fingers_still(context: RobotContext) -> Steps[None]:
    before = math.inf
    for _ in range(math.ceil(CLOSE_S / context.tick_s)):
        yield
        if abs(context.device.gripper.gap - before) < REST_M:
            return
        before = context.device.gripper.gap


def _press_to(context: RobotContext, bottom: ToolPose, limit: float) -> Steps[bool]:
    """Go down to a tool pose, or until it takes so much force [N]; return whether it got there."""
    yield from wait(context, STILL_S)
    way = bottom.position - context.commanded.position
    length = float(np.linalg.norm(way))
    motion = ForceMotion(context, way / length, ForceControl(limit), context.device.arm.force)
    while not motion.met_limit and motion.travel < length - REST_M:
        left = length - motion.travel
        speed = PRESS_SPEED if left > LIPS_WITHIN_M else LIPS_SPEED
        yield from motion.advance(min(speed, left / context.tick_s))
    motion.stop()
    return motion.travel >= length - REST_M


def _release(context: RobotContext) -> Steps[None]:
    start = context.device.gripper.gap / 2
    for tick in range(1, math.ceil(HAND_OPEN_M / OPEN_SPEED / context.tick_s) + 1):
        context.drive_fingers(start + min(HAND_OPEN_M, tick * OPEN_SPEED * context.tick_s))
        yield


def press_from_above(context: RobotContext, clip: PanelClip) -> Steps[bool]:
    """Press the wire between the lips with closed fingers; return whether they come down there."""
    bottom = lip_top(clip) + ABOVE_LIPS_M
    return (yield from _press_at(context, clip, 0.0, bottom, EXCESS * clip.retention_force))


def press_around(context: RobotContext, clip: PanelClip) -> Steps[None]:
    """Press a wire that stands off its clip between the lips, and down beside both ends.

    The fingers come no deeper than the lips' top, where a wire may stick between them: bent down
    beside them it is drawn in. What comes down at one side may rise at the other one.
    """
    yield from press_from_above(context, clip)
    out = _beside_clip(context, clip)
    for along in (-out, out):
        yield from _press_at(context, clip, along, FLOOR_CLEARANCE_M, ENOUGH * clip.retention_force)
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
    place = world_from_clip(clip, context.panel) @ Pose.level(along, 0.0, 0.0)
    above = _tool(context, place, _clear_height(context, clip) + ABOVE_WIRE_M)
    yield from rise(context)
    context.drive_fingers(0.0)
    yield from swing_to(context, above.at(z=context.commanded.z))
    yield from move_to(context, above, APPROACH_SPEED)
    yield from _fingers_still(context)
    arrived = yield from _press_to(context, above.at(z=bottom + context.fingers.below), limit)
    yield from move_to(context, above, APPROACH_SPEED)
    return arrived
