"""DiscardCable: release a wire's connected ends, and drop the wire into the scrap bin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.abilities.extract_cable import draw_out, put_away
from remodel_skills.abilities.locate_gearbox_component import locate_gearbox_component
from remodel_skills.goal_checks import Message
from remodel_skills.goals import DiscardGoal, ExtractGoal, LocateGoal
from remodel_skills.primitives.carrying import drop_into_bin, lift_out
from remodel_skills.primitives.grasping import holds, pick_end
from remodel_skills.primitives.in_ducts import let_go
from remodel_skills.primitives.observation.observing import loose_ends
from remodel_skills.primitives.picking_up import pick_up, take_up
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.cell.cell_design import bin_of
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import TerminalKey, nearest_terminal, opening_of


@dataclass(frozen=True)
class CableDiscarded:
    """No piece of the wire is left.

    Attributes:
        message: for a person.
    """

    message: str


def _goal(message: Message, board: Pose) -> DiscardGoal:
    return DiscardGoal(message.robot_name, message.cable_id)


@ability("DiscardCable", _goal)
def discard_cable(context: RobotContext, goal: DiscardGoal) -> Steps[CableDiscarded]:
    """Take the live wire, or one that was parked, off the panel, whatever holds it there."""
    belief = context.belief
    wire_id = goal.cable_id or context.wire.id
    if wire_id not in belief.fed:
        return CableDiscarded(f"no piece of {wire_id} is in the cell")
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
    return CableDiscarded(f"{wire_id} dropped into the scrap bin")


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
