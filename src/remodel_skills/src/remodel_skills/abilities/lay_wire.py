"""LayWire: one robot leads a wire into the ducts of its route, another holds its free end.

The leading hand closes its eyelet around the wire: the wire slides through it, and lies along the
duct behind it. The holding hand keeps the free part off the board, and comes nearer as that part
becomes shorter. At last the leading hand keeps the wire in its duct at the last corner, until
InsertCable has inserted the free end; FixCable then inspects the ducts.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goal_checks import (
    Message,
    check_held,
    check_live,
    require,
    require_robot,
)
from remodel_skills.parameters import (
    Parameters,
)
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.grasping import check_grip, inside_terminal
from remodel_skills.primitives.in_ducts import (
    AMONG_WIRES,
    LedPlace,
    behind_hand,
    eyelet_yaw,
    keep_in_duct,
    keeps_room,
    last_turn,
    lowest,
    places_along,
    withdraw,
)
from remodel_skills.primitives.motions import fingers_still, move_to
from remodel_skills.primitives.observation.checks import observe_board
from remodel_skills.primitives.observation.views import clear_sight
from remodel_skills.primitives.together import (
    bring_together,
    flat_hold,
    hold_off,
    move_together,
    slack_hold,
    steep_hold,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.laid_wire import Passing, WireLines, uppermost_past
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.panel import Duct, Panel, PanelWire, WireEnd, unit_x
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import slot_before


@dataclass(frozen=True)
class LayGoal:
    """Lead the live wire into the ducts of its route.

    Attributes:
        robot_name: of the robot that holds the free end.
        guide_name: of the robot that leads the wire.
        cable_id: the wire.
    """

    robot_name: str
    guide_name: str
    cable_id: str

    def __post_init__(self) -> None:
        """Refuse unknown robots, and one robot twice."""
        require_robot(self.robot_name)
        require(bool(self.guide_name.strip()), "guide_name is empty; it must name a second robot")
        require(
            self.robot_name != self.guide_name,
            f"robot_name and guide_name are both {self.robot_name!r}; it takes two robots",
        )

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a robot cannot do its part; asked for each of the two."""
        check_live(self.cable_id, panel, belief)
        wire = panel.wire(self.cable_id)
        require(
            bool(wire.ducts),
            f"the route of {wire.id!r} passes no duct; carry it with RouteWire",
        )
        free = _free_end(wire, belief)
        if belief.robot == self.guide_name:
            _check_guide(belief)
        else:
            check_held(belief, free)


def _free_end(wire: PanelWire, belief: BeliefState) -> WireEnd:
    """Return the loose end of a wire; raises unless the other one is fixed."""
    loose = [end for end, state in belief.ends.items() if state is EndState.LOOSE]
    require(
        len(loose) == 1 and belief.ends[loose[0].other] is EndState.FIXED,
        f"of {wire.id!r}, end a is {belief.ends[WireEnd.A].value} and end b is "
        f"{belief.ends[WireEnd.B].value}; one must be fixed and the other one loose",
    )
    return loose[0]


def _check_guide(belief: BeliefState) -> None:
    """Raise unless the hand is empty and has an eyelet."""
    if belief.grip is not None:
        raise AbilityError(
            Code.OTHER_CABLE_HELD,
            f"{belief.robot}, which leads the wire, holds end {belief.grip.end.value}; place it "
            "first",
        )
    fingers = belief.arm.fingers
    require(
        fingers.eyelet is not None,
        f"the fingers of {belief.robot}, {fingers.name!r}, have no eyelet; lead wires with a "
        "robot whose fingers have one",
    )


@dataclass(frozen=True)
class WireLaid:
    """A wire in its ducts, its free end in the holding hand.

    Attributes:
        message: for a person.
        peak_force: the largest level force at the leading hand [N].
    """

    message: str
    peak_force: float


def _goal(message: Message, board: Pose) -> LayGoal:
    return LayGoal(message.robot_name, message.guide_name, message.cable_id)


@ability("LayWire", _goal)
def lay_wire(holder: RobotContext, guide: RobotContext, goal: LayGoal) -> Steps[WireLaid]:
    """Lead the wire along its route, and keep it in its last duct."""
    check_grip(holder)
    try:
        peak = yield from _lead(holder, guide, _route(holder))
    except AbilityError:
        # What went wrong first is what counts.
        with suppress(AbilityError):
            yield from withdraw(guide, behind_hand(guide, holder))
        raise
    return WireLaid(f"{goal.cable_id} laid into {', '.join(holder.wire.ducts)}", peak)


def _route(holder: RobotContext) -> list[Array]:
    """Return the route from the fixed end to the free one, (3,) each [m], world frame.

    It enters and leaves the ducts where there are slots.
    """
    wire, grip = holder.wire, holder.belief.grip
    assert grip is not None, "the holder has the free end"
    board = holder.panel.world_from_panel
    points = [board.apply(np.array(point)) for point in wire.route]
    if grip.end is WireEnd.A:
        points.reverse()
    for end, index in ((grip.end.other, 1), (grip.end, -2)):
        opening = holder.panel.panel_from_socket(*wire.goes_to(end))
        slot = slot_before(holder.panel, opening)
        aside = 0.0 if slot is None else slot.aside
        points[index] = points[index] + aside * (board @ opening).rotation[:, 1]
    return points


def _lead(holder: RobotContext, guide: RobotContext, route: list[Array]) -> Steps[float]:
    """Take the wire where it comes out of the first slot, and lead it to the last one.

    Returns:
        The peak of the level pull at the guide [N].
    """
    fixture = guide.parameters.fixture
    grip = holder.belief.grip
    assert grip is not None, "the holder has the free end"
    fixed = guide.panel.world_from_panel @ guide.panel.panel_from_socket(
        *guide.wire.goes_to(grip.end.other)
    )
    depths = [
        np.array([0.0, 0.0, _rim(guide, at) - fixture.duct_under_rim_m - at[2]])
        for at in route[1:-1]
    ]
    led = [at + d for at, d in zip(route[1:-1], depths, strict=True)]
    places = list(places_along(led, fixture))
    over = _rim(guide, route[1]) + fixture.duct_over_rim_m
    places.insert(0, replace(places[0], at=np.array([*places[0].at[:2], over])))
    guide.report("searching for the wire at its slot", 0.2)
    inside = inside_terminal(guide, grip.end.other)
    left = guide.wire.length - grip.distance - inside - float(np.linalg.norm(route[1] - route[0]))
    x, y, z = (float(v) for v in route[1])
    # On the side to which the wire goes on: a hand that swings across pitches the wire in its grip.
    onward = (route[2] - route[1]) * [1.0, 1.0, 0.0]
    out = onward / np.linalg.norm(onward) - unit_x(fixed)
    hold = flat_hold(guide.parameters.wire)
    over_slot = ToolPose(x, y, guide.parameters.motion.travel_z_m, fixed.yaw)
    turned = guide.parameters.looking.slot_turn_rad
    visits = [
        (guide, replace(over_slot, z=height, yaw=fixed.yaw + turn))
        for height in (over_slot.z, z)
        for turn in (-turned, 0.0, turned)
    ]
    out /= np.linalg.norm(out)
    flat = hold_off(holder, ToolPose(x, y, z, 0.0), out, left, hold, visits)
    if flat:
        yield from move_together(flat, holder.parameters.motion.hold_speed_m_s)
    yield from clear_sight(guide, route[1][None])
    seen = yield from observe_board(guide, route[1][None])
    before = guide.belief.board_before(seen.picture.view)
    tool, is_seen = _find(guide, route[1], -unit_x(fixed), seen, before)
    # Lifted, the wire comes straight from its slot: the eyelet turns half the way there.
    turn = float(wrap_angle(fixed.yaw + math.pi - tool.yaw)) / 2
    yaw = tool.yaw + turn
    yaws = [tool.yaw, yaw, *(place.yaw for place in places)]
    tool = replace(tool, yaw=eyelet_yaw(guide, yaws))
    guide.report("taking the wire", 0.3)
    try:
        yield from _take(guide, tool, is_seen)
    except AbilityError as error:
        if is_seen or error.code is not Code.GRASP_MISSED:
            raise
        yield from _take(
            guide, tool.moved(onward / np.linalg.norm(onward), fixture.duct_onward_m), is_seen
        )
    free = guide.device.arm.force
    over_rim = guide.commanded.at(z=over - _eyelet_above(guide))
    lifted = replace(over_rim, yaw=over_rim.yaw + turn)
    peak = yield from _watched(guide, [(guide, lifted)], free)
    here = route[1]
    for i, place in enumerate(places):
        guide.report(f"leading the wire, {i + 1} of {len(places)}", 0.35 + 0.6 * i / len(places))
        target = place if place is not places[-1] else _last(guide, place, here, left)
        ahead = float(np.linalg.norm(target.at - here))
        left -= ahead
        turn = float(wrap_angle(target.yaw - yaw))
        peak = max(peak, (yield from _bring(holder, guide, target, turn, left, free)))
        if ahead > 0:
            left = yield from draw_straight(holder, target.at, left)
            _check_closed(guide)
        check_grip(holder)
        here, yaw = target.at, target.yaw
    # A wire that is pulled upwards would leave its ducts.
    risen = yield from _loosen(holder, guide, target, left, last_turn(places))
    corner, slot = route[-3], route[-2]
    if keeps_room(guide, corner, slot):
        guide.report("keeping the wire in its duct", 0.95)
        yield from keep_in_duct(guide, corner, slot)
    else:
        guide.report("releasing the wire", 0.95)
        yield from withdraw(guide, risen)
    return peak


def _last(guide: RobotContext, place: LedPlace, here: Array, left: float) -> LedPlace:
    """Return where the leading hand releases the wire: at the last slot, or before it.

    Args:
        guide: the leading hand's.
        place: at the last slot.
        here: where the eyelet is, (3,) [m].
        left: how long the wire is from there to the holder [m].
    """
    fixture, way = guide.parameters.fixture, here - place.at
    length = float(np.linalg.norm(way))
    back = min(max(0.0, fixture.duct_least_held_m - (left - length)), fixture.duct_rises_m, length)
    return replace(place, at=place.at + way / length * back)


def _rim(guide: RobotContext, point: Array) -> float:
    """Return the height of the walls of the wire's duct at a point (3,) [m]."""
    place = guide.panel.world_from_panel.inverse().apply(point)
    ducts = [duct for duct in guide.panel.ducts if duct.id in guide.wire.ducts]
    nearest = min(ducts, key=lambda duct: _outside(duct, place))
    return nearest.height


def _outside(duct: Duct, place: Array) -> float:
    """Return how far a point (3,) is outside a duct [m], panel frame."""
    along, across = np.abs(duct.panel_from_duct.inverse().apply(place)[:2])
    return float(max(along - duct.length / 2, across - duct.width / 2))


def _find(
    guide: RobotContext, crossing: Array, out: Array, seen: WireLines, before: Picture | None
) -> tuple[ToolPose, bool]:
    """Return the tool pose on the wire in its first duct, along the wire, and whether it is seen.

    The other hand holds it off: from above it is seen over those that lie beside it. Where others
    hide it at the crossing, it runs straight between where it is seen to both sides, or is taken
    on one side; where they hide it altogether, the pads are above where it comes out of its slot.
    """
    looking = guide.parameters.looking
    x, y, z = (float(v) for v in crossing)
    place = Pose.level(x, y, z, math.atan2(out[1], out[0]))
    behind, here, beyond = (
        uppermost_past(
            place @ Pose.level(along, 0.0, 0.0, 0.0), looking.slot_search_m, seen, before
        )
        for along in (-looking.direction_m, 0.0, looking.direction_m)
    )
    along, turn = 0.0, 0.0
    if behind is not None and beyond is not None:
        turn = math.atan2(beyond.aside - behind.aside, 2 * looking.direction_m)
        middle = Passing((behind.aside + beyond.aside) / 2, (behind.height + beyond.height) / 2)
        here = here or middle
    if here is None:
        along = -looking.direction_m if beyond is None else looking.direction_m
        here = behind or beyond
    if here is None:
        return ToolPose(x, y, z + guide.parameters.fixture.duct_hidden_m, place.yaw), False
    at = place.apply(np.array([along, here.aside, 0.0]))
    z = max(lowest(guide), here.height - _eyelet_above(guide))
    return ToolPose(float(at[0]), float(at[1]), z, place.yaw + turn), True


def _eyelet_above(guide: RobotContext) -> float:
    """Return how high the eyelet is above the tool centre [m]."""
    assert guide.fingers.eyelet is not None, "the goal's check"
    return guide.fingers.eyelet.above


def _take(guide: RobotContext, tool: ToolPose, is_seen: bool) -> Steps[None]:
    """Close the eyelet around the wire.

    A wire that is not seen must have been between the pads before. One that is seen and comes
    steeply from its slot keeps the pads apart in the eyelet too: it is taken between the heights,
    and `_check_closed` finds out whether it is in the eyelet once it is drawn straight.

    Raises:
        AbilityError: GRASP_MISSED when a wire that is not seen keeps the pads apart at all heights.
    """
    motion = guide.parameters.motion
    is_there = is_seen
    drops = guide.parameters.tool.eyelet_step_down_m * np.arange(
        guide.parameters.tool.eyelet_attempts_seen
        if is_seen
        else guide.parameters.tool.eyelet_attempts
    )
    guide.drive_fingers(guide.parameters.tool.open_m)
    yield from move_to(
        guide, tool.at(z=max(motion.travel_z_m, guide.commanded.z)), motion.free_speed_m_s
    )
    yield from move_to(guide, tool.at(z=motion.travel_z_m), motion.free_speed_m_s)
    for drop in drops:
        yield from _close_at(guide, tool, float(drop))
        is_between = _is_between(guide)
        if is_there and not is_between:
            return
        # The wire is between the pads, below the eyelet or above it.
        is_there = is_there or is_between
    if is_seen:
        yield from _close_at(guide, tool, float(np.median(drops)))
        return
    raise AbilityError(
        Code.GRASP_MISSED,
        f"the eyelet of {guide.name} does not close around {guide.wire.id!r} at {tool}, or up to "
        f"{drops[-1] * 1e3:.0f} mm lower: the pads were last "
        f"{guide.device.gripper.gap * 1e3:.1f} mm apart; draw the wire out and insert it again",
    )


def _close_at(guide: RobotContext, tool: ToolPose, drop: float) -> Steps[None]:
    """Open the hand, and close it so far below a tool pose [m]."""
    guide.drive_fingers(guide.parameters.tool.open_m)
    yield from fingers_still(guide)
    yield from move_to(
        guide,
        tool.at(z=max(lowest(guide), tool.z - drop)),
        guide.parameters.motion.approach_speed_m_s,
    )
    guide.drive_fingers(guide.parameters.tool.eyelet_apart_m / 2)
    yield from fingers_still(guide)


def _is_between(guide: RobotContext) -> bool:
    """Return whether something keeps the pads apart."""
    tool = guide.parameters.tool
    return guide.device.gripper.gap >= max(
        tool.eyelet_closed_m, tool.eyelet_closed_share * guide.wire.diameter
    )


def _check_closed(guide: RobotContext) -> None:
    """Raise GRASP_MISSED when a wire that is drawn straight keeps the pads apart."""
    if _is_between(guide):
        raise AbilityError(
            Code.GRASP_MISSED,
            f"{guide.wire.id!r} is between the pads of the leading hand, not in its eyelet: they "
            f"are {guide.device.gripper.gap * 1e3:.1f} mm apart; draw it out and place it again",
        )


def _bring(
    holder: RobotContext,
    guide: RobotContext,
    place: LedPlace,
    turn: float,
    left: float,
    free: Array,
) -> Steps[float]:
    """Lead the wire to a place and heading; the holder keeps `left` [m] of it off the board.

    Where it hangs in a slot of a wall, both hands lift it out over the rim, and go on: the leading
    hand alone would come too near to the holder.
    """
    fixture = holder.parameters.fixture
    x, y, z = (float(v) for v in place.at)
    z = max(lowest(guide), z - _eyelet_above(guide))
    tool = ToolPose(x, y, z, guide.commanded.yaw + turn)
    lead = partial(_lead_to, holder, guide, place, left=left, free=free)
    try:
        return (yield from lead(tool))
    except AbilityError as error:
        if error.code is not Code.SNAGGED:
            raise
        peak = error.found["peak_force"]
    lift = fixture.duct_over_rim_m + fixture.duct_under_rim_m
    both = [(robot, robot.commanded) for robot in (guide, holder)]
    lifted = [(robot, here.at(z=here.z + lift)) for robot, here in both]
    yield from move_together(lifted, holder.parameters.motion.leave_speed_m_s, allowed=AMONG_WIRES)
    for target in (tool.at(z=z + lift), tool):
        peak = max(peak, (yield from lead(target)))
    return peak


def _lead_to(
    holder: RobotContext,
    guide: RobotContext,
    place: LedPlace,
    tool: ToolPose,
    left: float,
    free: Array,
) -> Steps[float]:
    """Lead the wire to where the tool goes, for a place; return the peak of the level pull [N]."""
    out = np.array([math.cos(place.heading), math.sin(place.heading), 0.0])
    peak, hold = 0.0, steep_hold(guide.parameters.wire)
    for move in bring_together(guide, tool, holder, out, left, hold, place.yaw):
        peak = max(peak, (yield from _watched(guide, move, free)))
    return peak


def _loosen(
    holder: RobotContext, guide: RobotContext, place: LedPlace, left: float, turn: float
) -> Steps[ToolPose]:
    """Give the free part of the wire slack; return where the leading hand has room to rise to.

    After its last `turn` [rad] the wire springs outwards, into the notch of an open finger: the
    holder bends it the other way. `left` is how long the free part is [m].
    """
    fixture, motion = holder.parameters.fixture, holder.parameters.motion
    here = guide.commanded
    out = np.array([math.cos(place.heading), math.sin(place.heading), 0.0])
    risen = here.moved(-out, fixture.duct_back_m).at(z=max(here.z, motion.travel_z_m))
    inward = place.heading + math.copysign(fixture.duct_inward_rad, turn) if turn else place.heading
    inwards = np.array([math.cos(inward), math.sin(inward), 0.0])
    hold = slack_hold(guide.parameters.wire)
    moves = bring_together(guide, here, holder, inwards, left, hold, place.yaw, then=risen)
    for move in moves:
        yield from move_together(move, motion.lead_speed_m_s, motion.hold_speed_m_s)
    return risen


def draw_straight(holder: RobotContext, eyelet: Array, left: float) -> Steps[float]:
    """Draw the wire straight; return its length from the eyelet (3,) to the holder [m].

    A wire that sags ahead of the hand goes through the slots of the walls.

    Raises:
        AbilityError: GRASP_MISSED when it does not become straight: the eyelet does not lead it;
            GRASP_SLIPPED when the holder has lost it.
    """
    wire, arm = holder.parameters.wire, holder.parameters.motion
    away, step = holder.commanded.position - eyelet, arm.tighten_speed_m_s * holder.tick_s
    unit = away / np.linalg.norm(away)
    motion = ForceMotion(
        holder, unit, wire.most_taut_n, wire.sagging_stiffness_n_m, holder.empty_force
    )
    while not motion.met_limit and motion.force < wire.taut_n and motion.travel < arm.tighten_m:
        # What was commanded is where this tick began.
        if not holder.arm.reaches(holder.commanded.moved(unit, 2 * step)):
            break
        yield from motion.advance(arm.tighten_speed_m_s)
    motion.stop()
    apart = float(np.linalg.norm(holder.commanded.position - eyelet))
    if motion.force >= wire.taut_n or motion.met_limit:
        return apart
    if motion.travel >= arm.tighten_m:
        check_grip(holder)
        raise AbilityError(
            Code.GRASP_MISSED,
            f"{holder.wire.id!r} is not in the eyelet of the leading hand: drawn by "
            f"{motion.travel * 1e3:.0f} mm, it pulls with {motion.force:.1f} N, expected "
            f"{wire.taut_n:.1f} N; draw it out and place it again",
        )
    return max(left, apart)


def _max_pull(guide: RobotContext) -> float:
    """Return the pull that the wire's fixed ends stand [N]."""
    ends = guide.belief.ends.items()
    keys = [guide.wire.goes_to(end) for end, state in ends if state is EndState.FIXED]
    terminals = [guide.panel.component(part).terminal(name) for part, name in keys]
    return guide.parameters.terminal.lead_pull_share * min(
        terminal.retention_force for terminal in terminals
    )


def _watched(
    guide: RobotContext, move: list[tuple[RobotContext, ToolPose]], free: Array
) -> Steps[float]:
    """Move the hands together; return the peak of the level pull at the guide [N]."""
    motion = guide.parameters.motion
    peak, pulled_s, limit = 0.0, 0.0, _max_pull(guide)
    for _ in move_together(move, motion.lead_speed_m_s, motion.hold_speed_m_s, AMONG_WIRES):
        yield
        pull = float(np.linalg.norm((guide.device.arm.force - free)[:2]))
        peak = max(peak, pull)
        pulled_s = pulled_s + guide.tick_s if pull > limit else 0.0
        if pulled_s > guide.parameters.wire.snag_s:
            for context, _ in move:
                context.follow(context.device.arm.tool)
            raise AbilityError(
                Code.SNAGGED,
                f"{guide.wire.id!r} pulls at the leading hand with {pull:.0f} N at "
                f"{guide.device.arm.tool}, allowed: {limit:.0f} N; it hangs on "
                "something: draw it out and place it again",
                peak_force=peak,
            )
    return peak
