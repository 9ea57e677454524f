"""FixCable: close the terminal on the inserted end, do a pull test, and release it.

A spring clamp closed by itself as the end entered: there the pull test alone decides.

Fixed at both ends, a wire stays where it lies: then it is tucked in where it stands out of its
ducts, and observed from above: whether it lies in its forks and ducts, and whether its first end
is still in its terminal.
"""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import EndState
from remodel_skills.goal_checks import Message
from remodel_skills.goals import FixGoal
from remodel_skills.primitives.force_motion import pull_test
from remodel_skills.primitives.grasping import check_grip, release_fixed
from remodel_skills.primitives.in_ducts import tuck_in
from remodel_skills.primitives.motions import wait
from remodel_skills.primitives.observation.checks import check_ducts, check_end, check_forks
from remodel_skills.primitives.pushing import yielding_in
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose


@dataclass(frozen=True)
class CableFixed:
    """An end held by its terminal.

    Attributes:
        message: for a person.
        slip: movement of the end during the pull [m].
    """

    message: str
    slip: float


def _goal(message: Message, board: Pose) -> FixGoal:
    return FixGoal(
        robot_name=message.robot_name,
        cable_id=message.cable_id,
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        pull_test_force=message.pull_test_force,
    )


@ability("FixCable", _goal)
def fix_cable(context: RobotContext, goal: FixGoal) -> Steps[CableFixed]:
    """Close the clamp, pull, release the end, and lift the hand off; then check the whole wire."""
    belief = context.belief
    key = (goal.component_id, goal.terminal_id)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    context.report(f"closing {where}", 0.1)
    end = belief.grip.end if belief.grip is not None else None
    terminal = context.panel.component(goal.component_id).terminal(goal.terminal_id)
    closed = terminal.closes_itself or context.device.fixture.close_clamp(*key)
    yield from wait(context, context.parameters.motion.still_s)
    if end is None or not closed:
        raise AbilityError(
            Code.NOT_SEATED,
            f"the clamp of {where} met nothing: the end is not deep enough; extract, locate "
            "again, insert again",
        )
    context.report(f"pulling with {goal.pull_test_force:.0f} N", 0.3)
    slip = 0.0
    if goal.pull_test_force > 0:
        nominal = context.panel.panel_from_socket(*key)
        socket = nominal if belief.engaged is None else belief.engaged
        slip = yield from pull_test(
            context, socket, goal.pull_test_force, where, yielding=yielding_in(context, socket)
        )
    check_grip(context)
    yield from release_fixed(context, end, key)
    message = (
        f"end {end.value} of {goal.cable_id} fixed in {where}, slip {slip * 1e3:.2f} mm at "
        f"{goal.pull_test_force:.0f} N"
    )
    if belief.ends[end.other] is EndState.FIXED:
        forks = yield from check_forks(context)
        if forks:
            message += f"; the wire lies in {', '.join(fork.id for fork in forks)}"
        found = yield from tuck_in(context)
        yield from check_end(context, end.other)
        if found is not None:
            check_ducts(found, context.parameters.fixture)
            message += f"; it lies in its ducts at {found.share:.0%} of its route"
    return CableFixed(message, slip)
