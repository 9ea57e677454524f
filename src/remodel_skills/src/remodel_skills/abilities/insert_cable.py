"""InsertCable: push one end of a wire into a terminal until it seats."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.abilities.ability import ability
from remodel_skills.goal_checks import Message, parse_end, pose_from
from remodel_skills.goals import InsertGoal
from remodel_skills.primitives.grasping import check_grip, pick_end
from remodel_skills.primitives.in_ducts import let_go
from remodel_skills.primitives.motions import disengage
from remodel_skills.primitives.pushing import bring_before, find_in, judge_alignment, judge_depth
from remodel_skills.robot_context import RobotContext, Steps
from remodel_work.geometry import Pose
from remodel_work.routes import opening_of


@dataclass(frozen=True)
class CableInserted:
    """An end at the bottom of a terminal.

    Attributes:
        message: for a person.
        depth: from the opening to the tip, by the arm [m].
        peak_force: largest axial force at the wrist [N].
    """

    message: str
    depth: float
    peak_force: float


def _goal(message: Message, board: Pose) -> InsertGoal:
    return InsertGoal(
        robot_name=message.robot_name,
        cable_id=message.cable_id,
        end=parse_end(message.cable_end),
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        socket=pose_from("socket_pose", message.socket_pose, board),
        force_limit=message.force_limit,
    )


@ability("InsertCable", _goal)
def insert_cable(context: RobotContext, goal: InsertGoal) -> Steps[CableInserted]:
    """Pick the end if the hand is empty, push it into the opening, judge by travel and force.

    A hand that keeps the rest of the wire in its duct does so until the end is seated.
    """
    yield from disengage(context)
    if context.belief.grip is None:
        yield from pick_end(context, goal.end, 0.0, goal.socket, shares=(0.0, 0.45))
    context.report(f"carrying end {goal.end.value} to {goal.component_id}/{goal.terminal_id}", 0.5)
    yield from bring_before(context, goal.socket)
    check_grip(context)
    context.report("pushing", 0.75)
    context.belief.engaged = goal.socket
    terminal = context.panel.component(goal.component_id).terminal(goal.terminal_id)
    push = yield from find_in(context, goal.socket, terminal.depth, goal.force_limit)
    check_grip(context)
    key = (goal.component_id, goal.terminal_id)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    judge_alignment(push, opening_of(key, context.panel, context.belief.seen), terminal, where)
    judge_depth(push, terminal.depth, where, context.parameters.terminal)
    context.belief.seat(goal.end, key)
    yield from let_go(context)
    message = (
        f"end {goal.end.value} of {goal.cable_id} seated in "
        f"{goal.component_id}/{goal.terminal_id}, "
        f"{push.depth * 1e3:.1f} mm deep, {push.peak_force:.1f} N"
    )
    return CableInserted(message, push.depth, push.peak_force)
