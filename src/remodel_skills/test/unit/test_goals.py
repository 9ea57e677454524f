import math

import numpy as np
import pytest
from panels import example, panel, with_springs
from refusals import refused

from remodel_skills.abilities.extracting import ExtractGoal
from remodel_skills.abilities.inserting import ConnectGoal, FixGoal, InsertGoal
from remodel_skills.abilities.inspection import CheckGoal, LocateGoal
from remodel_skills.abilities.picking import PickGoal, PlaceGoal
from remodel_skills.abilities.route_wire import RouteGoal
from remodel_skills.belief_state import NO_CHANNEL, BeliefState, EndState, Feed, Grip
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.goal_checks import parse_end
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd
from remodel_work.robot.arm import ToolPose

PARAMETERS = read_parameters().parameters

SOCKET = BOARD @ panel().panel_from_socket("X1", "1")
NAN = float("nan")


def fed_belief():
    belief = BeliefState()
    belief.start_wire(Feed("W1", "A", 1), {})
    return belief


def test_a_push_that_its_spring_clamp_would_stop_is_refused():
    sprung = with_springs(panel(), 12.0)
    with refused(Code.INVALID_GOAL, r"lets a ferrule in with 12\.0 N"):
        insertion(force_limit=12.0).check(sprung, fed_belief(), PARAMETERS)
    insertion(force_limit=12.5).check(sprung, fed_belief(), PARAMETERS)


def holding(end):
    belief = fed_belief()
    belief.grip = Grip(
        end=end, distance=0.045, height=0.0, flip=0.0, tool=ToolPose(0.5, 0, 0.004, 0)
    )
    return belief


def insertion(**changes):
    fields = dict(
        robot_name="robot_1",
        cable_id="W1",
        end=WireEnd.A,
        component_id="X1",
        terminal_id="1",
        socket=SOCKET,
        force_limit=8.0,
    )
    return InsertGoal(**{**fields, **changes})


def fixing(terminal, force=5.0):
    return FixGoal("robot_1", "W1", *terminal, pull_test_force=force)


def pose_with(position=(0.5, 0.0, 0.03), quaternion=(0.0, 0.0, 0.0, 1.0)):
    return Pose(np.array(position), np.array(quaternion))


TILTED = pose_with(quaternion=(0, math.sin(0.4), 0, math.cos(0.4)))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: insertion(socket=pose_with((NAN, 0, 0))), "not finite"),
        (lambda: insertion(socket=pose_with(quaternion=(0, 0, 0, 0))), "length is 0"),
        (lambda: insertion(robot_name=" "), "robot_name is empty"),
        (lambda: connection(robot_name=""), "robot_name is empty"),
        (lambda: RouteGoal("robot_1", "W1", ()), "path is empty"),
        (lambda: parse_end("c"), "'a', 'b'"),
    ],
)
def test_a_goal_that_makes_no_sense_is_never_born(make, words):
    with refused(Code.INVALID_GOAL, words):
        make()


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (insertion(force_limit=NAN), "force_limit is nan"),
        (insertion(force_limit=-1.0), "allowed: 1 to 25 N"),
        (insertion(force_limit=math.inf), "force_limit is inf"),
        (insertion(socket=TILTED), "tilted"),
        (insertion(terminal_id="2", component_id="X2"), "locate"),
        (PlaceGoal("robot_1", "W1", TILTED), "target_pose"),
        (RouteGoal("robot_1", "W1", (TILTED,)), "path.0."),
        (ExtractGoal("robot_1", "W1", "X1", "1", TILTED), "socket_pose"),
        (
            PickGoal("robot_1", "W1", WireEnd.A, 0.5),
            "grasp_distance is 0.5 m; allowed: 0.02 to 0.08 m",
        ),
        (fixing(("X1", "1"), force=-0.1), "pull_test_force"),
    ],
)
def test_an_invalid_goal_is_refused(goal, words):
    with refused(Code.INVALID_GOAL, words):
        goal.check(panel(), fed_belief(), PARAMETERS)


@pytest.mark.parametrize(
    ("goal", "belief", "code", "words"),
    [
        (insertion(cable_id="W9"), fed_belief(), Code.UNKNOWN_NAME, "there are: W1, W2"),
        (insertion(cable_id="W2"), fed_belief(), Code.WIRE_NOT_FED, "'W1'"),
        (insertion(), BeliefState(), Code.WIRE_NOT_FED, "has not been fed"),
        (insertion(component_id="Q"), fed_belief(), Code.UNKNOWN_NAME, "X1, X2, X3, X4"),
        (insertion(terminal_id="9"), fed_belief(), Code.UNKNOWN_NAME, "there are: 1, 2"),
        (insertion(), holding(WireEnd.B), Code.OTHER_CABLE_HELD, "end b"),
        (fixing(("X1", "1")), fed_belief(), Code.NOTHING_HELD, "pick"),
        (
            RouteGoal("robot_1", "W1", (pose_with((1.5, 0, 0.1)),)),
            holding(WireEnd.A),
            Code.UNREACHABLE,
            "no arm posture",
        ),
        (
            PickGoal("robot_1", "W1", WireEnd.B, 0.0),
            holding(WireEnd.A),
            Code.OTHER_CABLE_HELD,
            "end a",
        ),
        (LocateGoal("X9", ""), BeliefState(), Code.UNKNOWN_NAME, "X1"),
    ],
)
def test_a_goal_that_the_cell_cannot_take_is_refused(goal, belief, code, words):
    with refused(code, words):
        goal.check(panel(), belief, PARAMETERS)


def test_an_end_in_another_robots_hand_is_left_there():
    belief = holding(WireEnd.A)
    other = belief.beside("robot_2", belief.arm)
    assert other.grip is None
    for goal in (PickGoal("robot_2", "W1", WireEnd.A, 0.0), insertion(robot_name="robot_2")):
        with refused(Code.OTHER_CABLE_HELD, "robot_1 holds end a"):
            goal.check(panel(), other, PARAMETERS)
    PickGoal("robot_2", "W1", WireEnd.B, 0.0).check(panel(), other, PARAMETERS)


def test_an_end_from_the_magazine_is_laid_down_wherever_the_goal_says():
    belief = holding(WireEnd.A)
    goal = PlaceGoal("robot_1", "W1", pose_with((1.5, 0, 0.1)))
    with pytest.raises(AbilityError, match="no arm posture"):
        goal.check(panel(), belief, PARAMETERS)
    belief.feed = Feed("W1", NO_CHANNEL, 1)
    goal.check(panel(), belief, PARAMETERS)


def test_an_occupied_terminal_names_its_occupant():
    belief = fed_belief()
    belief.occupied["X1", "1"] = ("W7", WireEnd.B)
    with refused(Code.TERMINAL_OCCUPIED, "end b of 'W7'"):
        insertion().check(panel(), belief, PARAMETERS)


def beside(y, yaw=math.pi):
    x, own, z = SOCKET.position
    return Pose.level(x, own + y, z, yaw)


@pytest.mark.parametrize(
    ("socket", "code", "words"),
    [
        (
            beside(0.018),
            Code.INVALID_GOAL,
            "at the opening of 'X1/2', 18 mm from where 'X1/1' is on",
        ),
        (beside(0.012), Code.INVALID_GOAL, "at the opening of 'X1/2'"),
        (beside(-0.012), Code.COMPONENT_DISPLACED, "12 mm and 0 deg from where 'X1/1' is on"),
        (beside(0.0, 2.9), Code.COMPONENT_DISPLACED, "0 mm and 14 deg"),
    ],
)
def test_an_opening_is_of_its_own_terminal(socket, code, words):
    with refused(code, words):
        insertion(socket=socket).check(panel(), fed_belief(), PARAMETERS)


def test_an_opening_is_compared_with_the_last_observation():
    belief = fed_belief()
    moved = np.array([0.0, 0.018, 0.0])
    drawn = BOARD @ panel().component("X1").panel_from_component
    belief.seen["X1"] = Pose(drawn.position + moved, drawn.quaternion)
    insertion(socket=beside(0.018)).check(panel(), belief, PARAMETERS)
    with pytest.raises(AbilityError, match="18 mm and 0 deg from where 'X1/1' was last seen"):
        insertion().check(panel(), belief, PARAMETERS)


def test_an_end_in_a_terminal_is_extracted_first():
    belief = fed_belief()
    belief.ends[WireEnd.A] = EndState.FIXED
    with pytest.raises(AbilityError, match="extract it first"):
        insertion().check(panel(), belief, PARAMETERS)


def test_good_goals_pass():
    insertion().check(panel(), fed_belief(), PARAMETERS)
    insertion().check(panel(), holding(WireEnd.A), PARAMETERS)
    LocateGoal("X2", "2").check(panel(), BeliefState(), PARAMETERS)


CONNECTORS = example("connectors")
FACE = BOARD @ CONNECTORS.panel_from_socket("U1", "J1")


def connection(**changes):
    fields = dict(
        robot_name="robot_1",
        connector_id="P1",
        cable_id="W1",
        component_id="U1",
        terminal_id="J1",
        socket=FACE,
        force_limit=30.0,
    )
    return ConnectGoal(**{**fields, **changes})


@pytest.mark.parametrize(
    ("goal", "code", "words"),
    [
        (connection(connector_id="P9"), Code.UNKNOWN_NAME, "there are: P1"),
        (connection(force_limit=-1.0), Code.INVALID_GOAL, "allowed: 1 to 40 N"),
        (
            connection(component_id="U2"),
            Code.INVALID_GOAL,
            "'P1' has 3 ways, 5.08 mm apart; 'U2/J1' takes 2",
        ),
        (connection(terminal_id="J2"), Code.INVALID_GOAL, "at the opening of 'U1/J1'"),
        (insertion(socket=FACE), Code.INVALID_GOAL, "place it with PlaceConnector"),
        (fixing(("U1", "J1")), Code.INVALID_GOAL, "is a header"),
        (CheckGoal("W1", WireEnd.A, "U1", "J1"), Code.INVALID_GOAL, "is a header"),
    ],
)
def test_goals_with_connectors_that_cannot_be_done_are_refused_with_the_reason(goal, code, words):
    with refused(code, words):
        goal.check(CONNECTORS, fed_belief(), PARAMETERS)
