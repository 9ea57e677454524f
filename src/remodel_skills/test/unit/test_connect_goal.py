"""Goals of PlaceConnector, and goals that a header does not take."""

import pytest
from panels import example

from remodel_skills.abilities.inserting import ConnectGoal, FixGoal, InsertGoal
from remodel_skills.abilities.inspection import CheckGoal
from remodel_skills.belief_state import BeliefState, Feed
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import BOARD, WireEnd

PARAMETERS = read_parameters().parameters
PANEL = example("connectors")
ROBOT = "robot_1"
FACE = BOARD @ PANEL.panel_from_socket("U1", "J1")


def connection(**changes):
    fields = dict(
        robot_name=ROBOT,
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
        (lambda: connection(connector_id="P9"), Code.UNKNOWN_NAME, "there are: P1"),
        (lambda: connection(force_limit=-1.0), Code.INVALID_GOAL, "allowed: 1 to 40 N"),
        (lambda: connection(robot_name=""), Code.INVALID_GOAL, "robot_name is empty"),
        (
            lambda: connection(component_id="U2"),
            Code.INVALID_GOAL,
            "'P1' has 3 ways, 5.08 mm apart; 'U2/J1' takes 2",
        ),
        (lambda: connection(terminal_id="J2"), Code.INVALID_GOAL, "at the opening of 'U1/J1'"),
        (
            lambda: InsertGoal(
                robot_name=ROBOT,
                cable_id="W1",
                end=WireEnd.A,
                component_id="X1",
                terminal_id="1",
                socket=FACE,
                force_limit=8.0,
            ),
            Code.INVALID_GOAL,
            "place it with PlaceConnector",
        ),
        (
            lambda: FixGoal(
                robot_name=ROBOT,
                cable_id="W1",
                component_id="U1",
                terminal_id="J1",
                pull_test_force=5.0,
            ),
            Code.INVALID_GOAL,
            "is a header",
        ),
        (lambda: CheckGoal("W1", WireEnd.A, "U1", "J1"), Code.INVALID_GOAL, "is a header"),
    ],
)
def test_goals_that_cannot_be_done_are_refused_with_the_reason(goal, code, words):
    belief = BeliefState()
    belief.start_wire(Feed("W1", "A", 1), {})
    with pytest.raises(AbilityError, match=words) as caught:
        goal().check(PANEL, belief, PARAMETERS)
    assert caught.value.code is code
