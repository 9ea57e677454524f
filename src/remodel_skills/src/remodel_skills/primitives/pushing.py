"""Push a held end into an opening, and judge by travel and force, as steps of an ability."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from remodel_skills.belief_state import Grip
from remodel_skills.force_control import WIRE_STIFFNESS, ForceControl, Yielding
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.holding import (
    HOLD_SPEED,
    bring_together,
    free_length,
    holder_of,
)
from remodel_skills.primitives.laying import carry_over
from remodel_skills.primitives.motions import (
    APPROACH_SPEED,
    CARRY_SPEED,
    TRAVEL_Z,
    move_to,
    wait,
)
from remodel_skills.primitives.observation.observing import observe_held_tip
from remodel_skills.primitives.together import move_together
from remodel_skills.push_monitor import PushMonitor
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import PanelTerminal, unit_x
from remodel_work.robot.arm import ToolPose
from remodel_work.slots import slot_before

# The tip goes to the opening faster than into it [m/s]: what stops it there must not hurt it.
APPROACH_OPENING_SPEED = 0.04
# The push goes on so far beyond where the bottom should be.
OVERTRAVEL_M = 0.008
SLOW_BEFORE_M = 0.001
HOME_BEFORE_M = 0.0015
# Resistance so far before or beyond the bottom counts as the bottom. A turn of the hand draws the
# wire back in the grip by up to 3 mm, so that it meets the bottom late, by the arm's measure. More
# than 0.5 mm early it meets an obstacle only, or passes below its opening.
SHORT_OF_BOTTOM_M = 0.002
BEYOND_BOTTOM_M = 0.006
# A wire buckles at the bottom so near to where that should be: a force that falls before is that of
# an end that is caught on its way in.
BUCKLES_M = 0.001
# Resistance before this depth is the face's or the funnel's.
FACE_M = 0.003
# Between the face and half the depth few ends in their openings meet more than this, in the mean;
# the tip of one that meets more may rub along the face, while its ferrule bends [N].
RUBS_N = 1.6
# A hand that is so far beyond the bottom slid along the wire, or bent it [m].
SLID_M = 0.001
STILL_S = 0.15
# A wire that comes through a slot beside the opening's axis is turned into the axis up to this
# depth [m]: kept straight from the slot on, it does not lean on the funnel.
TURNED_IN_M = 0.010
# A tip that is stopped at the face or in the funnel is turned up or down in the grip, if the wire
# was pulled or bent behind the hand: the opening is felt for with the hand so far higher [m], or so
# far from where the tip is seen in it, with so much force [N]; with 5 N it slides down the face.
FEELS_M = (0.0025, -0.0025, 0.005, -0.005, -0.0075)
FEEL_N = 3.0
# Pushed with 13 N against the face, a ferrule bends at its joint with the wire. A push that may be
# harder than this goes on with FEEL_N from so far before the face, until the tip is in [N, m].
BENDS_N = 10.0
GENTLE_BEFORE_M = 0.003
# An end that is in an opening guides the hand: a wire that lies askew in the grip would bend in
# front of it. The hand gives way by so much along the row of openings, and up or down [m].
YIELDS_ASIDE_M, YIELDS_UP_M = 0.0010, 0.0040
# An end so near to its place before an opening was brought there already [m, rad].
ALREADY_THERE_M = 0.004
ALREADY_THERE_RAD = 0.05
# Two hands carry a wire so high that its loop clears what stands on the plate [m].
BOTH_CARRY_Z = 0.32


@dataclass(frozen=True)
class Manner:
    """How something is pushed, where no force slows it down further.

    Attributes:
        inside: speed inside the terminal [m/s].
        home: speed near the bottom [m/s].
        stiffness: of what is pushed against what stops it [N/m].
        buckles: whether it may give way at the bottom.
    """

    inside: float
    home: float
    stiffness: float
    buckles: bool

    def speed_at(self, ahead: float, bottom: float) -> float:
        """Return the speed of a tip so far beyond the opening [m/s]."""
        if ahead > bottom - HOME_BEFORE_M:
            return self.home
        return self.inside if ahead > -SLOW_BEFORE_M else APPROACH_OPENING_SPEED


# A wire gives; a connector and its header do not, some 200 N a millimetre. A wire slows down before
# the bottom, or the jolt there would look like a wire that gives way.
WIRE = Manner(inside=0.02, home=0.006, stiffness=WIRE_STIFFNESS, buckles=True)
CONNECTOR = Manner(inside=0.01, home=0.002, stiffness=2e5, buckles=False)


@dataclass(frozen=True)
class Push:
    """How a push went.

    Attributes:
        tip: where it brought the tip, by the arm, (3,) [m], world frame.
        depth: of the tip beyond the opening [m].
        peak_force: the largest in any step, not filtered [N].
        stopped: whether it was stopped by the force limit, or by a wire that gave way at the
            bottom.
        felt: whether the opening was felt for: then the height of the tip is unknown.
        rubs: whether it was given up halfway, since the tip may rub along the face.
        jammed_at: at which depth the end was stopped and the hand alone went on [m]; None: the end
            went on too.
    """

    tip: Array
    depth: float
    peak_force: float
    stopped: bool
    felt: bool = False
    rubs: bool = False
    jammed_at: float | None = None

    @property
    def readings(self) -> dict[str, float]:
        """What it measured, by the name of the result's field."""
        return {"depth": self.depth, "peak_force": self.peak_force}


def tool_before(socket: Pose, grip: Grip, ahead: float) -> ToolPose:
    """Return the tool pose that holds the tip on an opening's axis, `ahead` [m] beyond it."""
    at = socket.position + unit_x(socket) * (ahead - grip.distance)
    x, y, z = (float(v) for v in at)
    return ToolPose(x, y, z - grip.height, socket.yaw - grip.flip)


def bring_before(context: RobotContext, socket: Pose) -> Steps[None]:
    """Carry the held end to in front of an opening.

    Where a slotted duct stands before it, the hand comes down beside the opening, so that the wire
    behind it goes down into a slot: over the wall it would have to bend upwards beside the grip.
    An end that is there already stays low: lifted, the wire would leave its forks.
    """
    target = tool_before(socket, _grip(context), -STANDOFF_M)
    slot = slot_before(context.panel, context.panel.world_from_panel.inverse() @ socket)
    above = target.moved(socket.rotation[:, 1], slot.aside if slot else 0.0)
    if not _is_at(context, above):
        holder = holder_of(context)
        if holder is not None:
            yield from _carry_both(context, holder, above, -unit_x(socket))
        yield from carry_over(context, above)
    yield from move_to(context, context.commanded.at(z=target.z), APPROACH_SPEED)
    slant = _slant(context, socket)
    yield from move_to(context, _way_in(socket, slant, _grip(context), target)(0.0), APPROACH_SPEED)
    yield from wait(context, STILL_S)


def _is_at(context: RobotContext, target: ToolPose) -> bool:
    here = context.commanded
    away = float(np.linalg.norm(here.position - target.position))
    return away < ALREADY_THERE_M and abs(wrap_angle(here.yaw - target.yaw)) < ALREADY_THERE_RAD


def _slant(context: RobotContext, socket: Pose) -> float:
    """Return the yaw from an opening's axis at which the held end comes to it [rad].

    A wire comes straight from the slot before the opening; a connector goes in straight.
    """
    slot = slot_before(context.panel, context.panel.world_from_panel.inverse() @ socket)
    is_wire = context.wire.connector_at(_grip(context).end) is None
    return slot.slant if slot is not None and is_wire else 0.0


def _way_in(
    socket: Pose, slant: float, grip: Grip, straight: ToolPose
) -> Callable[[float], ToolPose]:
    """Return the tool poses that push an end in, for each travel [m] from STANDOFF_M before it.

    Args:
        socket: the opening's frame, x into the terminal.
        slant: yaw from its axis at which the end comes to it [rad].
        grip: on the end.
        straight: the tool pose that holds the end along the axis.
    """

    def tool(travel: float) -> ToolPose:
        ahead = travel - STANDOFF_M
        turn = slant * (1.0 - min(1.0, max(0.0, ahead / TURNED_IN_M)))
        along = socket.rotation @ np.array([math.cos(turn), math.sin(turn), 0.0])
        tip = socket.position + (unit_x(socket) if ahead > 0 else along) * ahead
        x, y, _ = (float(v) for v in tip - along * grip.distance)
        return ToolPose(x, y, straight.z, straight.yaw + turn)

    return tool


def _carry_both(
    context: RobotContext, holder: RobotContext, target: ToolPose, out: Array
) -> Steps[None]:
    """Carry a wire that two hands hold: this one to above its target, the other out of its way."""
    both = (context, holder)
    high = [(robot, robot.commanded.at(z=max(BOTH_CARRY_Z, robot.commanded.z))) for robot in both]
    yield from move_together(high, HOLD_SPEED)
    length = free_length(context, holder)
    for height, then in ((BOTH_CARRY_Z, None), (TRAVEL_Z, target)):
        above = target.at(z=height)
        for move in bring_together(context, above, holder, out, length, then=then, keeps=True):
            yield from move_together(move, CARRY_SPEED, HOLD_SPEED)


def _grip(context: RobotContext) -> Grip:
    if context.belief.grip is None:
        raise AbilityError(Code.NOTHING_HELD, "the gripper is empty; pick the wire first")
    return context.belief.grip


def push_in(
    context: RobotContext,
    socket: Pose,
    bottom: float,
    limit: float,
    manner: Manner = WIRE,
    until_in: float = math.inf,
) -> Steps[Push]:
    """Push the held end from in front of an opening until a force stops it, or gives way.

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        bottom: how deep the tip should come [m].
        limit: force at which the push stops [N].
        manner: how it is pushed.
        until_in: the same, from the face until the tip is half as deep: it may be beside the
            opening. If this is less than the limit, a tip that rubs is pushed no further [N].
    """
    into, grip = unit_x(socket), _grip(context)
    context.free_force = context.device.arm.force
    monitor = PushMonitor(manner.buckles)
    slant, here = _slant(context, socket), context.commanded
    way = _way_in(socket, slant, grip, replace(here, yaw=here.yaw - slant)) if slant else None
    motion = ForceMotion(context, into, ForceControl(limit, manner.stiffness), way=way)
    ahead, stopped, is_tared, in_opening = -STANDOFF_M, False, False, False
    rubs, work = False, 0.0
    while ahead < bottom + OVERTRAVEL_M and not stopped and not rubs:
        before = ahead
        yield from motion.advance(manner.speed_at(ahead, bottom))
        ahead = motion.travel - STANDOFF_M
        if until_in < limit and FACE_M <= before < bottom / 2:
            work += motion.force * (ahead - before)
            rubs = ahead >= bottom / 2 and work > RUBS_N * (bottom / 2 - FACE_M)
        if not is_tared and ahead >= -GENTLE_BEFORE_M:
            is_tared = True
            motion.tare()  # the wire pulls at a hand that draws back, and brakes one that goes on
        if manner.buckles and not in_opening and ahead >= FACE_M:
            in_opening = True
            motion.yield_to(yielding_in(socket))
        at_face = -GENTLE_BEFORE_M <= ahead < bottom / 2
        motion.limit_to(min(limit, until_in) if at_face else limit)
        monitor = monitor.then(motion.force, near_bottom=ahead >= bottom - BUCKLES_M)
        stopped = motion.met_limit or monitor.gave_way
        context.report("pushing", 0.75 + 0.2 * np.clip(ahead / bottom, 0, 1))
    motion.stop()
    tip = (
        _held_tip(grip, context.device.arm.tool) - motion.yielded
    )  # the end is where the opening keeps it
    yield from wait(context, 0.1)
    depth = float((tip - socket.position) @ into)
    at_bottom = stopped and -SHORT_OF_BOTTOM_M <= depth - bottom <= SLID_M
    pressed_at = None if at_bottom else motion.loop.pressed_at
    jammed_at = None if pressed_at is None else pressed_at - STANDOFF_M
    return Push(tip, depth, motion.loop.peak, stopped, rubs=rubs, jammed_at=jammed_at)


def yielding_in(socket: Pose) -> Yielding:
    """Return how a hand gives way to the opening that its wire is in."""
    aside, up = socket.rotation[:, 1], np.array([0.0, 0.0, 1.0])
    return Yielding(np.array([aside, up]), np.array([YIELDS_ASIDE_M, YIELDS_UP_M]))


def find_in(context: RobotContext, socket: Pose, bottom: float, limit: float) -> Steps[Push]:
    """Push the held end in as `push_in`; if that stops early, observe the tip and feel.

    If it goes in freely nowhere, it is pushed where it first rubbed, or else where it began.
    """
    start = context.commanded
    until_in = limit if limit <= BENDS_N else FEEL_N
    push = yield from push_in(context, socket, bottom, limit, until_in=until_in)
    if _is_in(push, bottom):
        return push
    peak_force, rubbed = push.peak_force, [start] * push.rubs
    context.report("feeling for the opening", 0.8)
    yield from _back_to(context, start)
    for above in (yield from _feels(context)):
        there = start.at(z=start.z + above)
        yield from _back_to(context, start, there)
        push = yield from push_in(context, socket, bottom, limit, until_in=FEEL_N)
        peak_force = max(peak_force, push.peak_force)
        if _is_in(push, bottom):
            return replace(push, peak_force=peak_force, felt=True)
        rubbed += [there] * push.rubs
    last = rubbed[0] if rubbed else start
    yield from _back_to(context, start, last)
    push = yield from push_in(context, socket, bottom, limit)
    return replace(push, peak_force=max(peak_force, push.peak_force), felt=last is not start)


def _is_in(push: Push, bottom: float) -> bool:
    """Return whether a push was neither stopped by the face of the opening nor led along it."""
    return not push.rubs and (not push.stopped or push.depth >= bottom / 2)


def _feels(context: RobotContext) -> Steps[tuple[float, ...]]:
    """Return how far above where it was the hand feels for the opening [m], in this order.

    A tip that is seen from above is first brought to the opening's height.
    """
    expected = _held_tip(_grip(context), context.device.arm.tool)
    seen = yield from observe_held_tip(context, expected)
    if seen is None:
        return FEELS_M
    lower = float(expected[2] - seen.tip[2])
    return tuple(lower + above for above in (0.0, *FEELS_M[:-1]))


def _held_tip(grip: Grip, tool: ToolPose) -> Array:
    """Return where the tip of the held end is, (3,) [m], if it has not turned in the grip."""
    yaw = tool.yaw + grip.flip
    along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    return tool.position + along * grip.distance + np.array([0.0, 0.0, grip.height])


def _back_to(context: RobotContext, *tools: ToolPose) -> Steps[None]:
    """Draw the end back to where its push began, and on to where the next one begins."""
    for tool in tools:
        yield from move_to(context, tool, APPROACH_SPEED / 2)
    yield from wait(context, STILL_S)


def judge_alignment(push: Push, mouth: Pose, terminal: PanelTerminal, where: str) -> None:
    """Raise INSERTION_MISALIGNED when the tip is beside the opening, as last observed.

    Openings stand in a row: a tip that was felt in is in the one at its place along the row.
    """
    beside = mouth.inverse().apply(push.tip)[1:]
    aside = abs(float(beside[0])) if push.felt else float(np.linalg.norm(beside))
    reach = terminal.bore / 2 + terminal.chamfer
    if aside > reach:
        raise AbilityError(
            Code.INSERTION_MISALIGNED,
            f"the tip is {aside * 1e3:.1f} mm beside the axis of {where}, whose opening takes "
            f"{reach * 1e3:.1f} mm, at {push.peak_force:.1f} N; extract, locate again, insert "
            "again",
            **push.readings,
        )


def judge_depth(push: Push, bottom: float, where: str, early: float = SHORT_OF_BOTTOM_M) -> None:
    """Raise unless a push was stopped at the bottom, or up to `early` [m] before it."""
    if push.jammed_at is not None and FACE_M <= push.jammed_at < bottom - early:
        raise _jammed(push, push.jammed_at, bottom, where)
    depth = push.depth * 1e3
    if not push.stopped or push.depth > bottom + BEYOND_BOTTOM_M:
        raise AbilityError(
            Code.INSERTION_NO_CONTACT,
            f"pushed to {depth:.1f} mm without meeting the bottom of {where} at "
            f"{bottom * 1e3:.1f} mm; extract, locate again, insert again",
            **push.readings,
        )
    if push.depth >= bottom - early:
        return
    if push.depth < FACE_M:
        raise AbilityError(
            Code.INSERTION_MISALIGNED,
            f"{push.peak_force:.1f} N at {depth:.1f} mm: the tip sits on the face of {where}; "
            "extract, locate again, insert again",
            **push.readings,
        )
    raise _jammed(push, push.depth, bottom, where)


def _jammed(push: Push, depth: float, bottom: float, where: str) -> AbilityError:
    return AbilityError(
        Code.INSERTION_JAMMED,
        f"{push.peak_force:.1f} N at {depth * 1e3:.1f} of {bottom * 1e3:.1f} mm in {where}; "
        "extract, locate again, insert again; a second time at the same depth: check for an "
        "obstacle",
        **push.readings,
    )
