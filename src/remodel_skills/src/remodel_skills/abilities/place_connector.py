"""PlaceConnector: push a connector into its header until it latches, then do a pull test."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.abilities.ability import ability
from remodel_skills.goal_checks import Message, pose_from
from remodel_skills.goals import ConnectGoal
from remodel_skills.primitives.force_motion import pull_test
from remodel_skills.primitives.grasping import check_grip, pick_end, release_fixed
from remodel_skills.primitives.motions import disengage
from remodel_skills.primitives.pushing import (
    Push,
    bring_before,
    judge_alignment,
    judge_depth,
    of_connector,
    push_in,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.routes import opening_of


@dataclass(frozen=True)
class ConnectorPlaced:
    """A connector that has latched.

    Attributes:
        message: for a person.
        depth: from the header's face to the pins' tips, by the arm [m].
        peak_force: largest axial force at the wrist during the push [N].
    """

    message: str
    depth: float
    peak_force: float


def _goal(message: Message, board: Pose) -> ConnectGoal:
    return ConnectGoal(
        robot_name=message.robot_name,
        connector_id=message.connector_id,
        cable_id=message.cable_id,
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        socket=pose_from("socket_pose", message.socket_pose, board),
        force_limit=message.force_limit,
    )


@ability("PlaceConnector", _goal)
def place_connector(context: RobotContext, goal: ConnectGoal) -> Steps[ConnectorPlaced]:
    """Pick the connector if the hand is empty, push, judge by travel and force, pull, release."""
    belief = context.belief
    connector = context.wire.connector(goal.connector_id)
    key = (goal.component_id, goal.terminal_id)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    yield from disengage(context)
    if belief.grip is None:
        yield from pick_end(context, connector.end, 0.0, goal.socket, shares=(0.0, 0.45))
    context.report(f"carrying {connector.id} to {where}", 0.5)
    yield from bring_before(context, goal.socket)
    check_grip(context)
    context.report("pushing", 0.75)
    belief.engaged = goal.socket
    bottom, limit = connector.pin_length, goal.force_limit
    push = yield from push_in(
        context, goal.socket, bottom, limit, manner=of_connector(context.parameters)
    )
    check_grip(context)
    header = context.panel.component(goal.component_id).terminal(goal.terminal_id)
    judge_alignment(push, opening_of(key, context.panel, belief.seen), header, where)
    terminal = context.parameters.terminal
    judge_depth(push, bottom, where, terminal, terminal.short_of_face_m)
    context.report(f"pulling with {context.parameters.terminal.latch_pull_n:.0f} N", 0.9)
    yield from _check_latched(context, goal.socket, push, where)
    check_grip(context)
    yield from release_fixed(context, connector.end, key)
    message = (
        f"{connector.id} of {goal.cable_id} latched in {goal.component_id}/{goal.terminal_id}, "
        f"{push.depth * 1e3:.1f} mm deep, {push.peak_force:.1f} N"
    )
    return ConnectorPlaced(message, push.depth, push.peak_force)


def _check_latched(context: RobotContext, socket: Pose, push: Push, where: str) -> Steps[None]:
    """Pull; raises INSUFFICIENT_FORCE when the connector comes out again."""
    terminal = context.parameters.terminal
    try:
        yield from pull_test(
            context, socket, terminal.latch_pull_n, where, terminal.connector_stiffness_n_m
        )
    except AbilityError as error:
        if error.code is not Code.PULLED_OUT:
            raise
        raise AbilityError(
            Code.INSUFFICIENT_FORCE,
            f"the connector was pressed home in {where} with {push.peak_force:.1f} N and did not "
            f"latch: it came out at less than {terminal.latch_pull_n:.0f} N; place it again "
            "with a higher force limit",
            **push.readings,
        ) from error
