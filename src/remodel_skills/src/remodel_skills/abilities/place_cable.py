"""PlaceCable: lay the held end down and release it."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import EndState
from remodel_skills.goal_checks import Message, pose_from
from remodel_skills.goals import PlaceGoal
from remodel_skills.primitives.carrying import drop_into_bin, lay_down, let_down
from remodel_skills.primitives.force_motion import pull_out
from remodel_skills.primitives.motions import held_tool
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose


@dataclass(frozen=True)
class CablePlaced:
    """A wire laid down.

    Attributes:
        message: for a person.
    """

    message: str


def _goal(message: Message, board: Pose) -> PlaceGoal:
    return PlaceGoal(
        message.robot_name, message.cable_id, pose_from("target_pose", message.target_pose, board)
    )


@ability("PlaceCable", _goal)
def place_cable(context: RobotContext, goal: PlaceGoal) -> Steps[CablePlaced]:
    """Carry the held end to the target, release it there, and lift the empty hand.

    An end that sits in a terminal is pulled out; one that is fixed there is released where it is.
    An end from the magazine has no place on the board: it is released above where the hand is. If
    nothing else holds the wire, it is dropped into the scrap bin.
    """
    yield from _draw_out(context)
    if context.belief.by_magazine and not _is_held_elsewhere(context):
        wire_id = context.wire.id
        yield from drop_into_bin(context, (0.2, 1.0))
        return CablePlaced(f"{wire_id} dropped into the scrap bin: nothing else held it")
    if context.belief.by_magazine:
        yield from let_down(context)
    else:
        yield from lay_down(context, held_tool(context, goal.target), (0.0, 1.0))
    x, y = context.commanded.x, context.commanded.y
    return CablePlaced(f"{context.wire.id} laid down at x {x * 1e3:.0f}, y {y * 1e3:.0f} mm")


def _is_held_elsewhere(context: RobotContext) -> bool:
    """Return whether a terminal or another robot holds the other end."""
    belief = context.belief
    assert belief.grip is not None, "the goal's check"
    other = belief.grip.end.other
    in_hand = any(grip.end is other for grip in belief.hands.values())
    return in_hand or belief.ends[other] is not EndState.LOOSE


def _draw_out(context: RobotContext) -> Steps[None]:
    """Pull the held end out of its opening, unless it is fixed there."""
    belief = context.belief
    grip, socket = belief.grip, belief.engaged
    if grip is None or socket is None:
        return
    context.report("pulling the end out of its opening", 0.0)
    try:
        yield from pull_out(context, socket, context.parameters.terminal.pushed_in_holds_n)
        belief.loosen(grip.end)
    except AbilityError as error:
        if error.code is not Code.EXTRACTION_STUCK:
            raise
        belief.ends[grip.end] = EndState.FIXED
        text = f"{error}; it is fixed: extract it first"
        raise AbilityError(error.code, text, **error.found) from error
