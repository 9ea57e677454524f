import dataclasses

import pytest
from panels import panel, with_first
from refusals import refused

from remodel_skills.abilities.lay_wire import LayGoal
from remodel_skills.belief_state import BeliefState, EndState, Feed, Grip
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN, ToolPose
from remodel_work.robot.fingers import PANDA_FINGERS, Eyelet

PARAMETERS = read_parameters().parameters

GOAL = LayGoal("robot_2", "robot_1", "W1")
LEADING = dataclasses.replace(
    PANDA_AT_ORIGIN,
    fingers=dataclasses.replace(PANDA_FINGERS, eyelet=Eyelet(0.003, 0.012, 0.011)),
)


def ducted(*ducts):
    """Return the panel with a wire W1 whose route passes ducts."""
    return with_first(panel(), "wires", ducts=ducts)


def grip(end):
    return Grip(end=end, distance=0.045, height=0.0, flip=0.0, tool=ToolPose(0.5, 0, 0.004, 0))


@pytest.fixture
def holder():
    """Return the belief as robot_2 has it: end a is fixed, end b in its hand."""
    belief = BeliefState(robot="robot_2")
    belief.start_wire(Feed("W1", "", 1), {})
    belief.ends[WireEnd.A] = EndState.FIXED
    belief.grip = grip(WireEnd.B)
    return belief


def guide_beside(holder, arm=LEADING):
    return holder.beside("robot_1", arm)


def refusal(belief, goal=GOAL, ducts=("D1",)):
    with pytest.raises(AbilityError) as raised:
        goal.check(ducted(*ducts), belief, PARAMETERS)
    return raised.value.code, str(raised.value)


def test_a_held_wire_whose_other_end_is_fixed_can_be_laid(holder):
    GOAL.check(ducted("D1"), holder, PARAMETERS)
    GOAL.check(ducted("D1"), guide_beside(holder), PARAMETERS)


def test_either_end_may_be_the_fixed_one(holder):
    holder.ends.update({WireEnd.A: EndState.LOOSE, WireEnd.B: EndState.FIXED})
    code, text = refusal(holder)
    assert (code, "not end a" in text) == (Code.OTHER_CABLE_HELD, True)
    holder.grip = grip(WireEnd.A)
    GOAL.check(ducted("D1"), holder, PARAMETERS)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (EndState.LOOSE, EndState.LOOSE),
        (EndState.SEATED, EndState.LOOSE),
        (EndState.FIXED, EndState.FIXED),
    ],
)
def test_one_end_is_fixed_and_the_other_one_loose(holder, a, b):
    holder.ends.update({WireEnd.A: a, WireEnd.B: b})
    code, text = refusal(holder)
    assert code is Code.INVALID_GOAL
    assert f"end a is {a.value} and end b is {b.value}" in text


def test_the_wire_is_live_and_its_route_passes_ducts(holder):
    assert refusal(holder, ducts=()) == (
        Code.INVALID_GOAL,
        "the route of 'W1' passes no duct; carry it with RouteWire",
    )
    assert refusal(BeliefState(robot="robot_2"))[0] is Code.WIRE_NOT_FED
    unknown = dataclasses.replace(GOAL, cable_id="W9")
    assert refusal(holder, unknown)[0] is Code.UNKNOWN_NAME


def test_the_holder_holds_the_free_end_and_the_guide_nothing(holder):
    holder.grip = None
    assert refusal(holder)[0] is Code.NOTHING_HELD
    guide = guide_beside(holder)
    guide.grip = grip(WireEnd.B)
    code, text = refusal(guide)
    assert (code, "robot_1" in text) == (Code.OTHER_CABLE_HELD, True)


def test_the_guide_has_an_eyelet(holder):
    code, text = refusal(guide_beside(holder, PANDA_AT_ORIGIN))
    assert (code, "'panda_fingers', have no eyelet" in text) == (Code.INVALID_GOAL, True)


@pytest.mark.parametrize(
    ("robot", "guide", "words"),
    [
        ("robot_1", "robot_1", "are both 'robot_1'"),
        ("robot_2", " ", "guide_name is empty"),
        ("", "robot_1", "robot_name is empty"),
    ],
)
def test_it_takes_two_robots(robot, guide, words):
    with refused(Code.INVALID_GOAL, words):
        LayGoal(robot, guide, "W1")
