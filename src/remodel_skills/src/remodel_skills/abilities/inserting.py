"""Ends go into terminals and stay there: InsertCable, FixCable, PlaceConnector.

InsertCable pushes one end of a wire into a terminal until it seats. FixCable closes the terminal on
the inserted end, does a pull test, and releases it; a spring clamp closed by itself as the end
entered, and a push must have brought the end to its bottom. Fixed at both ends, a wire stays where
it lies: then it is tucked in where it stands out of its ducts, and observed from above: whether it
lies in its forks and ducts, and whether its first end is still in its terminal.

PlaceConnector pushes a connector into its header until it latches, then does a pull test.
"""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goal_checks import (
    Message,
    check_clamp,
    check_hand,
    check_held,
    check_live,
    check_opening,
    check_socket,
    parse_end,
    pose_from,
    require_level,
    require_number,
    require_pose,
    require_robot,
)
from remodel_skills.parameters import Parameters, TerminalParameters
from remodel_skills.primitives.force_motion import pull_test
from remodel_skills.primitives.grasping import check_grip, pick_end, release_fixed
from remodel_skills.primitives.in_ducts import let_go, tuck_in
from remodel_skills.primitives.motions import disengage, wait
from remodel_skills.primitives.observation.checks import check_ducts, check_end, check_forks
from remodel_skills.primitives.pushing import (
    Push,
    bring_before,
    find_in,
    judge_alignment,
    judge_depth,
    of_connector,
    push_in,
    yielding_in,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.routes import opening_of


@dataclass(frozen=True)
class InsertGoal:
    """Push an end into a terminal whose opening is at `socket`, x into the terminal."""

    robot_name: str
    cable_id: str
    end: WireEnd
    component_id: str
    terminal_id: str
    socket: Pose
    force_limit: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        _require_push(self)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the end cannot go there, or the grip does not hold the force."""
        _check_push(self, parameters.tool.grip_holds_n, parameters)
        check_live(self.cable_id, panel, belief)
        check_clamp(self.component_id, self.terminal_id, panel)
        connector = panel.wire(self.cable_id).connector_at(self.end)
        if connector is not None:
            raise AbilityError(
                Code.INVALID_GOAL,
                f"end {self.end.value} of {self.cable_id!r} is connector {connector.id!r}; place "
                "it with PlaceConnector",
            )
        terminal = panel.component(self.component_id).terminal(self.terminal_id)
        if self.force_limit <= terminal.insertion_force:
            raise AbilityError(
                Code.INVALID_GOAL,
                f"force_limit is {self.force_limit:.1f} N; the spring of "
                f"'{self.component_id}/{self.terminal_id}' lets a ferrule in with "
                f"{terminal.insertion_force:.1f} N: allow more, so that it meets the bottom",
            )
        check_free(self, self.end, panel, belief, parameters.terminal)


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


def _insert_goal(message: Message, board: Pose) -> InsertGoal:
    return InsertGoal(
        robot_name=message.robot_name,
        cable_id=message.cable_id,
        end=parse_end(message.cable_end),
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        socket=pose_from("socket_pose", message.socket_pose, board),
        force_limit=message.force_limit,
    )


@ability("InsertCable", _insert_goal)
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


@dataclass(frozen=True)
class FixGoal:
    """Close a terminal on the end in the hand; a pull test of 0 N means none."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    pull_test_force: float

    def __post_init__(self) -> None:
        """Refuse unknown robots."""
        require_robot(self.robot_name)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or the grip does not hold the force."""
        most_n = parameters.tool.grip_holds_n
        require_number("pull_test_force", self.pull_test_force, 0.0, most_n, unit="N")
        check_live(self.cable_id, panel, belief)
        check_clamp(self.component_id, self.terminal_id, panel)
        check_held(belief)


@dataclass(frozen=True)
class CableFixed:
    """An end held by its terminal.

    Attributes:
        message: for a person.
        slip: movement of the end during the pull [m].
    """

    message: str
    slip: float


def _fix_goal(message: Message, board: Pose) -> FixGoal:
    return FixGoal(
        robot_name=message.robot_name,
        cable_id=message.cable_id,
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        pull_test_force=message.pull_test_force,
    )


@ability("FixCable", _fix_goal)
def fix_cable(context: RobotContext, goal: FixGoal) -> Steps[CableFixed]:
    """Close the clamp, pull, release the end, and lift the hand off; then check the whole wire."""
    belief = context.belief
    key = (goal.component_id, goal.terminal_id)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    context.report(f"closing {where}", 0.1)
    end = belief.grip.end if belief.grip is not None else None
    terminal = context.panel.component(goal.component_id).terminal(goal.terminal_id)
    if terminal.closes_itself:
        met = belief.occupied.get(key) == (goal.cable_id, end)
        reason = f"no push has brought the end to the bottom of {where}"
    else:
        met = context.device.fixture.close_clamp(*key)
        reason = f"the clamp of {where} met nothing: the end is not deep enough"
    yield from wait(context, context.parameters.motion.still_s)
    if end is None or not met:
        text = f"{reason}; extract, locate again, insert again"
        raise AbilityError(Code.NOT_SEATED, text)
    context.report(f"pulling with {goal.pull_test_force:.0f} N", 0.3)
    slip = 0.0
    if goal.pull_test_force > 0:
        nominal = context.panel.world_from_panel @ context.panel.panel_from_socket(*key)
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


@dataclass(frozen=True)
class ConnectGoal:
    """Push a connector into the header whose face is at `socket`, x into it."""

    robot_name: str
    connector_id: str
    cable_id: str
    component_id: str
    terminal_id: str
    socket: Pose
    force_limit: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        _require_push(self)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the connector does not fit or cannot go there, or for too much force."""
        _check_push(self, parameters.tool.grip_holds_connector_n, parameters)
        check_live(self.cable_id, panel, belief)
        connector = panel.wire(self.cable_id).connector(self.connector_id)
        header = panel.component(self.component_id).terminal(self.terminal_id)
        if not connector.fits(header):
            raise AbilityError(
                Code.INVALID_GOAL,
                f"connector {connector.id!r} has {connector.ways} ways, "
                f"{connector.pitch * 1e3:.2f} mm apart; '{self.component_id}/{self.terminal_id}' "
                f"takes {header.ways}, {header.pitch * 1e3:.2f} mm apart",
            )
        check_free(self, connector.end, panel, belief, parameters.terminal)


def _require_push(goal: InsertGoal | ConnectGoal) -> None:
    require_robot(goal.robot_name)
    require_pose("socket_pose", goal.socket)


def _check_push(goal: InsertGoal | ConnectGoal, most_n: float, parameters: Parameters) -> None:
    require_level("socket_pose", goal.socket, parameters.terminal.level_rad)
    least_n = parameters.tool.least_push_n
    require_number("force_limit", goal.force_limit, least_n, most_n, unit="N")


def check_free(
    goal: InsertGoal | ConnectGoal,
    end: WireEnd,
    panel: Panel,
    belief: BeliefState,
    tolerances: TerminalParameters,
) -> None:
    """Raise unless a loose end, in the hand or to be picked, may now go into an opening."""
    key = (goal.component_id, goal.terminal_id)
    check_socket(key, goal.socket, panel, belief, tolerances)
    check_opening(key, goal.socket, panel, belief, tolerances)
    check_hand(belief, end)
    if belief.ends[end] is not EndState.LOOSE:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"end {end.value} of {goal.cable_id!r} is {belief.ends[end].value} in a terminal; "
            "extract it first",
        )
    occupant = belief.occupied.get(key)
    if occupant is not None:
        raise AbilityError(
            Code.TERMINAL_OCCUPIED,
            f"terminal '{'/'.join(key)}' holds end {occupant[1].value} of {occupant[0]!r}",
        )


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


def _connect_goal(message: Message, board: Pose) -> ConnectGoal:
    return ConnectGoal(
        robot_name=message.robot_name,
        connector_id=message.connector_id,
        cable_id=message.cable_id,
        component_id=message.component_id,
        terminal_id=message.terminal_id,
        socket=pose_from("socket_pose", message.socket_pose, board),
        force_limit=message.force_limit,
    )


@ability("PlaceConnector", _connect_goal)
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
