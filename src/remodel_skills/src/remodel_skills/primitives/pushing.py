"""Push a held end into an opening, and judge by travel and force, as steps of an ability."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from remodel_skills.belief_state import Grip
from remodel_skills.force_control import Yielding
from remodel_skills.goal_checks import check_held
from remodel_skills.parameters import Parameters, TerminalParameters, WireParameters
from remodel_skills.primitives.carrying import carry_over
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.motions import move_to, wait
from remodel_skills.primitives.observation.observing import observe_held_tip
from remodel_skills.primitives.together import bring_together, free_length, holder_of, move_together
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import PanelTerminal, unit_x
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import slot_before


@dataclass(frozen=True)
class PushMonitor:
    """The forces of a push so far, along it [N].

    Attributes:
        buckles: whether what is pushed may give way.
        wire: the forces that show it.
        peak: the largest.
        peak_before: the largest before it came near the bottom.
        now: the last.
    """

    buckles: bool
    wire: WireParameters
    peak: float = 0.0
    peak_before: float = 0.0
    now: float = 0.0

    def then(self, force: float, *, near_bottom: bool) -> PushMonitor:
        """Return the forces with one more."""
        peak = max(self.peak, force)
        before = self.peak_before if near_bottom else peak
        return replace(self, peak=peak, peak_before=before, now=force)

    @property
    def gave_way(self) -> bool:
        """Whether the wire buckles at the bottom."""
        free = self.buckles and self.peak_before < self.wire.free_way_n
        return (
            free
            and self.peak >= self.wire.gives_way_from_n
            and self.now < self.peak - self.wire.gives_way_by_n
        )


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

    def speed_at(self, ahead: float, bottom: float, parameters: Parameters) -> float:
        """Return the speed of a tip so far beyond the opening [m/s]."""
        if ahead > bottom - parameters.terminal.home_before_m:
            return self.home
        is_before = ahead <= -parameters.terminal.slow_before_m
        return parameters.motion.opening_speed_m_s if is_before else self.inside


def of_wire(parameters: Parameters) -> Manner:
    """Return how a wire is pushed, which gives."""
    motion, stiffness = parameters.motion, parameters.wire.grip_stiffness_n_m
    return Manner(motion.wire_inside_speed_m_s, motion.wire_home_speed_m_s, stiffness, buckles=True)


def of_connector(parameters: Parameters) -> Manner:
    """Return how a connector is pushed, which does not give, nor does its header."""
    return Manner(
        inside=parameters.motion.connector_inside_speed_m_s,
        home=parameters.motion.connector_home_speed_m_s,
        stiffness=parameters.terminal.connector_stiffness_n_m,
        buckles=False,
    )


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
    motion = context.parameters.motion
    target = tool_before(socket, check_held(context.belief), -STANDOFF_M)
    slot = slot_before(context.panel, context.panel.world_from_panel.inverse() @ socket)
    above = target.moved(socket.rotation[:, 1], slot.aside if slot else 0.0)
    if not _is_at(context, above):
        holder = holder_of(context)
        if holder is not None:
            yield from _carry_both(context, holder, above, -unit_x(socket))
        yield from carry_over(context, above)
    yield from move_to(context, context.commanded.at(z=target.z), motion.approach_speed_m_s)
    slant = _slant(context, socket)
    yield from move_to(
        context, _way_in(context, socket, slant, target)(0.0), motion.approach_speed_m_s
    )
    yield from wait(context, motion.force_still_s)


def _is_at(context: RobotContext, target: ToolPose) -> bool:
    terminal = context.parameters.terminal
    here = context.commanded
    away = float(np.linalg.norm(here.position - target.position))
    return (
        away < terminal.already_there_m
        and abs(wrap_angle(here.yaw - target.yaw)) < terminal.already_there_rad
    )


def _slant(context: RobotContext, socket: Pose) -> float:
    """Return the yaw from an opening's axis at which the held end comes to it [rad].

    A wire comes straight from the slot before the opening; a connector goes in straight.
    """
    slot = slot_before(context.panel, context.panel.world_from_panel.inverse() @ socket)
    is_wire = context.wire.connector_at(check_held(context.belief).end) is None
    return slot.slant if slot is not None and is_wire else 0.0


def _way_in(
    context: RobotContext, socket: Pose, slant: float, straight: ToolPose
) -> Callable[[float], ToolPose]:
    """Return the tool poses that push an end in, for each travel [m] from STANDOFF_M before it.

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        slant: yaw from its axis at which the end comes to it [rad].
        straight: the tool pose that holds the end along the axis.
    """
    grip, turned_in_m = check_held(context.belief), context.parameters.terminal.turned_in_m

    def tool(travel: float) -> ToolPose:
        ahead = travel - STANDOFF_M
        turn = slant * (1.0 - min(1.0, max(0.0, ahead / turned_in_m)))
        along = socket.rotation @ np.array([math.cos(turn), math.sin(turn), 0.0])
        tip = socket.position + (unit_x(socket) if ahead > 0 else along) * ahead
        x, y, _ = (float(v) for v in tip - along * grip.distance)
        return ToolPose(x, y, straight.z, straight.yaw + turn)

    return tool


def _carry_both(
    context: RobotContext, holder: RobotContext, target: ToolPose, out: Array
) -> Steps[None]:
    """Carry a wire that two hands hold: this one to above its target, the other out of its way."""
    motion = context.parameters.motion
    both = (context, holder)
    high = [
        (robot, robot.commanded.at(z=max(motion.both_carry_z_m, robot.commanded.z)))
        for robot in both
    ]
    yield from move_together(high, motion.hold_speed_m_s)
    length = free_length(context, holder)
    for height, then in ((motion.both_carry_z_m, None), (motion.travel_z_m, target)):
        above = target.at(z=height)
        for move in bring_together(context, above, holder, out, length, then=then, keeps=True):
            yield from move_together(move, motion.carry_speed_m_s, motion.hold_speed_m_s)


def push_in(
    context: RobotContext,
    socket: Pose,
    bottom: float,
    limit: float,
    manner: Manner | None = None,
    until_in: float = math.inf,
) -> Steps[Push]:
    """Push the held end from in front of an opening until a force stops it, or gives way.

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        bottom: how deep the tip should come [m].
        limit: force at which the push stops [N].
        manner: how it is pushed; None: as a wire.
        until_in: the same, from the face until the tip is half as deep: it may be beside the
            opening. If this is less than the limit, a tip that rubs is pushed no further [N].
    """
    into, grip = unit_x(socket), check_held(context.belief)
    context.free_force = context.device.arm.force
    terminal, wire = context.parameters.terminal, context.parameters.wire
    manner = manner or of_wire(context.parameters)
    monitor = PushMonitor(manner.buckles, wire)
    slant, here = _slant(context, socket), context.commanded
    way = _way_in(context, socket, slant, replace(here, yaw=here.yaw - slant)) if slant else None
    motion = ForceMotion(context, into, limit, manner.stiffness, way=way)
    ahead, stopped, is_tared, in_opening = -STANDOFF_M, False, False, False
    rubs, work = False, 0.0
    farthest = bottom + terminal.overtravel_m
    if manner.buckles:
        farthest = min(farthest, _room_before_face(context, bottom))
    while ahead < farthest and not stopped and not rubs:
        before = ahead
        yield from motion.advance(manner.speed_at(ahead, bottom, context.parameters))
        ahead = motion.travel - STANDOFF_M
        if until_in < limit and terminal.face_m <= before < bottom / 2:
            work += motion.force * (ahead - before)
            rubs = ahead >= bottom / 2 and work > wire.rubs_n * (bottom / 2 - terminal.face_m)
        if not is_tared and ahead >= -terminal.gentle_before_m:
            is_tared = True
            motion.tare()  # the wire pulls at a hand that draws back, and brakes one that goes on
        if manner.buckles and not in_opening and ahead >= terminal.face_m:
            in_opening = True
            motion.yield_to(yielding_in(context, socket))
        at_face = -terminal.gentle_before_m <= ahead < bottom / 2
        motion.limit_to(min(limit, until_in) if at_face else limit)
        monitor = monitor.then(motion.force, near_bottom=ahead >= bottom - wire.buckles_within_m)
        stopped = motion.met_limit or monitor.gave_way
        context.report("pushing", 0.75 + 0.2 * np.clip(ahead / bottom, 0, 1))
    motion.stop()
    # The end is where the opening keeps it.
    tip = _held_tip(grip, context.device.arm.tool) - motion.yielded
    yield from wait(context, context.parameters.motion.still_s)
    depth = float((tip - socket.position) @ into)
    at_bottom = stopped and -terminal.short_of_bottom_m <= depth - bottom <= terminal.slid_m
    pressed_at = None if at_bottom else motion.loop.pressed_at
    jammed_at = None if pressed_at is None else pressed_at - STANDOFF_M
    return Push(tip, depth, motion.loop.peak, stopped, rubs=rubs, jammed_at=jammed_at)


def _room_before_face(context: RobotContext, bottom: float) -> float:
    """Return how deep the held end may come before the fingers meet the terminal's face [m].

    Where the end gives way, no force stops the hand before they do, and then one far beyond the
    limit.

    Raises:
        AbilityError: UNREACHABLE when the end would not come to the bottom.
    """
    grip, width = check_held(context.belief), context.fingers.width
    room = grip.distance - width / 2 - context.parameters.tool.before_face_m
    if room < bottom:
        raise AbilityError(
            Code.UNREACHABLE,
            f"held {grip.distance * 1e3:.1f} mm behind its tip by fingers that are "
            f"{width * 1e3:.0f} mm wide, the end would come {room * 1e3:.1f} mm deep, needed: "
            f"{bottom * 1e3:.1f} mm; release it, and pick it farther behind its tip",
        )
    return room


def yielding_in(context: RobotContext, socket: Pose) -> Yielding:
    """Return how a hand gives way to the opening that its wire is in."""
    aside, up = socket.rotation[:, 1], np.array([0.0, 0.0, 1.0])
    terminal, wire = context.parameters.terminal, context.parameters.wire
    most = np.array([terminal.yields_aside_m, terminal.yields_up_m])
    return Yielding(np.array([aside, up]), most, wire.grip_stiffness_n_m)


def find_in(context: RobotContext, socket: Pose, bottom: float, limit: float) -> Steps[Push]:
    """Push the held end in as `push_in`; if that stops early, observe the tip and feel.

    If it goes in freely nowhere, it is pushed where it first rubbed, or else where it began.
    """
    wire = context.parameters.wire
    start = context.commanded
    until_in = limit if limit <= wire.most_at_face_n(context.wire) else wire.feel_n
    push = yield from push_in(context, socket, bottom, limit, until_in=until_in)
    if _is_in(push, bottom):
        return push
    peak_force, rubbed = push.peak_force, [start] * push.rubs
    context.report("feeling for the opening", 0.8)
    yield from _back_to(context, start)
    for above in (yield from _feels(context)):
        there = start.at(z=start.z + above)
        yield from _back_to(context, start, there)
        push = yield from push_in(context, socket, bottom, limit, until_in=wire.feel_n)
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
    terminal = context.parameters.terminal
    expected = _held_tip(check_held(context.belief), context.device.arm.tool)
    seen = yield from observe_held_tip(context, expected)
    if seen is None:
        return terminal.feels_m
    lower = float(expected[2] - seen.tip[2])
    return tuple(lower + above for above in (0.0, *terminal.feels_m[:-1]))


def _held_tip(grip: Grip, tool: ToolPose) -> Array:
    """Return where the tip of the held end is, (3,) [m], if it has not turned in the grip."""
    yaw = tool.yaw + grip.flip
    along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    return tool.position + along * grip.distance + np.array([0.0, 0.0, grip.height])


def _back_to(context: RobotContext, *tools: ToolPose) -> Steps[None]:
    """Draw the end back to where its push began, and on to where the next one begins."""
    motion = context.parameters.motion
    for tool in tools:
        yield from move_to(context, tool, motion.approach_speed_m_s / 2)
    yield from wait(context, motion.force_still_s)


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


def judge_depth(
    push: Push, bottom: float, where: str, terminal: TerminalParameters, early: float | None = None
) -> None:
    """Raise unless a push was stopped at the bottom, or up to `early` [m] before it.

    None: as early as a wire may be stopped.
    """
    early = terminal.short_of_bottom_m if early is None else early
    if push.jammed_at is not None and terminal.face_m <= push.jammed_at < bottom - early:
        raise _jammed(push, push.jammed_at, bottom, where)
    depth = push.depth * 1e3
    if not push.stopped or push.depth > bottom + terminal.beyond_bottom_m:
        raise AbilityError(
            Code.INSERTION_NO_CONTACT,
            f"pushed to {depth:.1f} mm without meeting the bottom of {where} at "
            f"{bottom * 1e3:.1f} mm; extract, locate again, insert again",
            **push.readings,
        )
    if push.depth >= bottom - early:
        return
    if push.depth < terminal.face_m:
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
