"""Wires are taken off the panel again: ExtractCable, DiscardCable.

ExtractCable opens the terminal, pulls the wire's end out, and lays it down in its channel.
DiscardCable releases a wire's connected ends, and drops the wire into the scrap bin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import Done, ability
from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.belief_state import BeliefState, EndState, Grip
from remodel_skills.goal_checks import (
    Message,
    check_hands_empty,
    check_held,
    check_live,
    check_socket,
    pose_from,
    require_level,
    require_pose,
    require_robot,
)
from remodel_skills.parameters import Parameters
from remodel_skills.primitives.carrying import drop_into_bin, lay_down, let_down, lift_out, tip_of
from remodel_skills.primitives.force_motion import pull_out
from remodel_skills.primitives.grasping import (
    close_on_wire,
    grasp_distance,
    holds,
    opening_beside_neighbours,
    pick_end,
)
from remodel_skills.primitives.in_ducts import let_go
from remodel_skills.primitives.motions import choose_flip, clear_hand, move_to, swing_to
from remodel_skills.primitives.observation.observing import loose_ends
from remodel_skills.primitives.picking_up import pick_up, take_up
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.cell.cell_design import bin_of
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import TerminalKey, nearest_terminal, opening_of


@dataclass(frozen=True)
class ExtractGoal:
    """Pull a wire's end out of the terminal whose opening is at `socket`, x into it."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    socket: Pose

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        require_robot(self.robot_name)
        require_pose("socket_pose", self.socket)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the wire or the socket is not there."""
        terminal = parameters.terminal
        require_level("socket_pose", self.socket, terminal.level_rad)
        check_live(self.cable_id, panel, belief)
        check_socket((self.component_id, self.terminal_id), self.socket, panel, belief, terminal)


@dataclass(frozen=True)
class CableExtracted:
    """An end laid down, the hand empty.

    Attributes:
        message: for a person.
        peak_force: largest axial force at the wrist during the pull [N].
    """

    message: str
    peak_force: float


def _extract_goal(message: Message, board: Pose) -> ExtractGoal:
    return ExtractGoal(
        robot_name=message.robot_name,
        cable_id=message.cable_id,
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        socket=pose_from("socket_pose", message.socket_pose, board),
    )


@ability("ExtractCable", _extract_goal)
def extract_cable(context: RobotContext, goal: ExtractGoal) -> Steps[CableExtracted]:
    """Bring the wire back to where its end lies loose in the channel, from wherever it is."""
    end, peak = yield from draw_out(context, goal)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    if context.belief.grip is None:
        context.report("clearing the hand", 0.5)
        yield from clear_hand(context)
        return CableExtracted(f"nothing to pull out of {where}: end {end.value} lies loose", 0.0)
    yield from put_away(context, (0.6, 1.0))
    return CableExtracted(f"end {end.value} of {goal.cable_id} out of {where}, laid down", peak)


def draw_out(context: RobotContext, goal: ExtractGoal) -> Steps[tuple[WireEnd, float]]:
    """Draw an end out of its terminal, and keep it in the hand.

    Returns:
        Which end, and the largest axial force at the wrist [N]. The hand is empty if the end was
        neither in the hand nor in the terminal: it lies loose.
    """
    belief = context.belief
    take_up(context, goal.cable_id)
    yield from let_go(context)
    end = _end_at(context, goal)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    if belief.grip is not None and not holds(context):
        belief.grip = None  # it slipped out; the end may sit in the terminal
    in_opening = belief.engaged is not None or belief.ends[end] is not EndState.LOOSE
    if belief.grip is None and in_opening:
        # Before the terminal opens: a bent wire springs out of one that is open.
        yield from _regrasp(context, end, goal)
    context.report(f"opening {where}", 0.3)
    context.device.fixture.open_clamp(goal.component_id, goal.terminal_id)
    peak = 0.0
    if belief.grip is None:
        belief.engaged = None
    elif belief.engaged is not None:
        context.report(f"pulling end {end.value} out of {where}", 0.4)
        peak = yield from pull_out(context, belief.engaged, context.parameters.tool.grip_holds_n)
    belief.loosen(end)
    return end, peak


def put_away(context: RobotContext, shares: tuple[float, float]) -> Steps[None]:
    """Lay the held end down where it was picked, or let it down where it is.

    An end from the magazine does not go back there.
    """
    grip = context.belief.grip
    if grip is None:
        return
    if context.belief.by_magazine:
        yield from let_down(context)
    else:
        target = where_it_lay(context, grip, context.belief.picked_at[grip.end])
        yield from lay_down(context, target, shares)


def where_it_lay(context: RobotContext, grip: Grip, back: Grip) -> ToolPose:
    """Return the tool pose that lays the tip down where it lay when it was picked."""
    yaw = back.tool.yaw + back.flip
    x, y = tip_of(back.tool, back) - grip.distance * np.array([math.cos(yaw), math.sin(yaw)])
    z = max(
        context.wire.radius - grip.height,
        context.fingers.below + context.parameters.tool.floor_clearance_m,
    )
    return ToolPose(float(x), float(y), z, yaw - grip.flip)


def _end_at(context: RobotContext, goal: ExtractGoal) -> WireEnd:
    """Return which end is meant.

    The one in the hand, the one in that terminal, or the one that belongs there.
    """
    belief = context.belief
    if belief.grip is not None:
        return belief.grip.end
    occupant = belief.occupied.get((goal.component_id, goal.terminal_id))
    if occupant is not None and occupant[0] == goal.cable_id:
        return occupant[1]
    belongs = context.wire.goes_to(WireEnd.B) == (goal.component_id, goal.terminal_id)
    return WireEnd.B if belongs else WireEnd.A


def _regrasp(context: RobotContext, end: WireEnd, goal: ExtractGoal) -> Steps[None]:
    """Grasp the wire at the opening; the hand stays empty if it is not there."""
    context.report("grasping the wire at the opening", 0.1)
    terminal = context.panel.component(goal.component_id).terminal(goal.terminal_id)
    connector = context.wire.connector_at(end)
    inside = terminal.depth if connector is None else connector.pin_length
    try:
        yield from _grasp_at_opening(context, end, goal, inside)
    except AbilityError as error:
        if error.code is not Code.GRASP_MISSED:
            raise


def _grasp_at_opening(
    context: RobotContext, end: WireEnd, goal: ExtractGoal, inside: float
) -> Steps[None]:
    """Grasp the wire just outside an opening; `inside` [m] of it are in the terminal."""
    motion = context.parameters.motion
    socket, terminal = goal.socket, (goal.component_id, goal.terminal_id)
    then = context.belief.picked_at[end]
    # Between a terminal and a duct there is no more room than an insertion takes.
    by_magazine = context.belief.by_magazine
    outside = context.fingers.width / 2 + context.parameters.tool.pads_clear_m
    distance = grasp_distance(context, end) if by_magazine else inside + outside
    place = tool_before(
        socket, Grip(end=end, distance=distance, height=0.0, flip=0.0, tool=then.tool), inside
    )
    flip = choose_flip(
        context.arm,
        (place.x, place.y),
        socket.yaw,
        (then.tool.x, then.tool.y),
        then_tip_yaw=then.tool.yaw + then.flip,
    )
    tool = ToolPose(place.x, place.y, place.z, socket.yaw - flip)
    yield from clear_hand(context)
    yield from swing_to(context, tool.at(z=max(motion.travel_z_m, context.commanded.z)))
    context.drive_fingers(opening_beside_neighbours(context, terminal))
    yield from move_to(context, tool.at(z=tool.z + motion.approach_above_m), motion.free_speed_m_s)
    yield from move_to(context, tool, motion.approach_speed_m_s)
    picked = context.belief.picked_at[end]
    yield from close_on_wire(
        context, Grip(end=end, distance=distance, height=0.0, flip=flip, tool=tool)
    )
    context.belief.picked_at[end] = picked
    context.belief.engaged = socket


@dataclass(frozen=True)
class DiscardGoal:
    """Take a wire off the panel; an empty `cable_id` means the one in the hand."""

    robot_name: str
    cable_id: str

    def __post_init__(self) -> None:
        """Refuse unknown robots."""
        require_robot(self.robot_name)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or a hand holds what it must place first."""
        if not self.cable_id:
            check_held(belief)
        elif panel.wire(self.cable_id).id not in belief.fed:
            return  # there is nothing to discard
        if belief.feed is not None and self.cable_id not in ("", belief.feed.wire_id):
            check_hands_empty(belief)
        for robot, grip in belief.hands.items():
            if robot != belief.robot:
                raise AbilityError(
                    Code.OTHER_CABLE_HELD,
                    f"{robot} holds end {grip.end.value}; have it placed first",
                )


def _discard_goal(message: Message, board: Pose) -> DiscardGoal:
    return DiscardGoal(message.robot_name, message.cable_id)


@ability("DiscardCable", _discard_goal)
def discard_cable(context: RobotContext, goal: DiscardGoal) -> Steps[Done]:
    """Take the live wire, or one that was parked, off the panel, whatever holds it there."""
    belief = context.belief
    wire_id = goal.cable_id or context.wire.id
    if wire_id not in belief.fed:
        return Done(f"no piece of {wire_id} is in the cell")
    above_bin = bin_of(context.design, context.panel)
    if belief.grip is not None and not holds(context):
        belief.grip = None
        if not goal.cable_id:
            raise AbilityError(Code.NOTHING_HELD, f"{wire_id!r} slipped out of the fingers")
    take_up(context, wire_id)
    yield from let_go(context)
    occupants = {wire for wire, _ in belief.occupied.values()}
    was_connected = belief.engaged is not None or wire_id in occupants
    yield from _release_ends(context)
    if belief.grip is None:
        yield from _pick(context, above_bin)
    elif context.wire.ducts and was_connected:
        yield from lift_out(context)
    yield from drop_into_bin(context, (0.7, 1.0))
    return Done(f"{wire_id} dropped into the scrap bin")


def _release_ends(context: RobotContext) -> Steps[None]:
    """Draw each end of the live wire out of its terminal; the last one stays in the hand."""
    belief, wire_id = context.belief, context.wire.id
    if belief.engaged is not None:
        yield from _draw_out(
            context, nearest_terminal(belief.engaged.position, context.panel, belief.seen)
        )
    for key in [key for key, (wire, _) in belief.occupied.items() if wire == wire_id]:
        yield from put_away(context, (0.1, 0.2))
        yield from _draw_out(context, key)


def _draw_out(context: RobotContext, terminal: TerminalKey) -> Steps[None]:
    """Draw an end out of a terminal."""
    belief = context.belief
    component_id, terminal_id = terminal
    if belief.engaged is None and component_id not in belief.seen:
        yield from locate_gearbox_component(context, LocateGoal(component_id, terminal_id))
    socket = belief.engaged or opening_of(terminal, context.panel, belief.seen)
    goal = ExtractGoal(
        robot_name=context.name,
        cable_id=context.wire.id,
        component_id=component_id,
        terminal_id=terminal_id,
        socket=socket,
    )
    yield from draw_out(context, goal)


def _pick(context: RobotContext, above_bin: ToolPose) -> Steps[None]:
    """Pick a loose end, the one nearer to the bin first: then the wire trails along its channel.

    Where neither is found, pick the wire up between them.
    """

    def away(end: WireEnd) -> float:
        return float(np.linalg.norm(context.belief.expected[end][:2] - above_bin.position[:2]))

    failures: list[AbilityError] = []
    for end in sorted(loose_ends(context), key=away):
        socket = _toward(above_bin, context, end)
        try:
            yield from pick_end(context, end, 0.0, socket, shares=(0.5, 0.7))
        except AbilityError as error:
            failures.append(error)
        else:
            return
    if not (yield from pick_up(context)):
        raise failures[-1]


def _toward(above_bin: ToolPose, context: RobotContext, end: WireEnd) -> Pose:
    """Return the tip's pose over the bin, pointing as it does in its channel."""
    feed = context.belief.feed
    assert feed is not None, "the wire is live"
    out = feed.direction if end is WireEnd.B else -feed.direction
    return Pose.level(above_bin.x, above_bin.y, above_bin.z, out * math.pi / 2)
