import dataclasses
import math

import numpy as np
import pytest
from panels import panel, with_first
from refusals import refused

from remodel_skills.abilities.place_pin import PlacePinGoal, pin_row
from remodel_skills.belief_state import BeliefState, EndState, Feed
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import BOARD, WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN, Arm

PARAMETERS = read_parameters().parameters

FACING = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))
WIRE = panel().wires[0]  # 0.48 m
GOOD = PlacePinGoal(
    robot_1="robot_1",
    robot_2="robot_2",
    path_space=0.10,
    connector_space=0.472,
    centered=True,
    rotate=True,
    show_in_tf=False,
)


def goal(**changes):
    return dataclasses.replace(GOOD, **changes)


def fed(arm=PANDA_AT_ORIGIN):
    belief = BeliefState(arm=arm)
    belief.start_wire(Feed("W1", "A", 1), {})
    return belief


def places(some_goal):
    """Return the names and places of a row on the panel."""
    row = pin_row(some_goal, WIRE, panel())
    inverse = BOARD.inverse()
    return {name: inverse.apply(pose.position)[:2].round(6).tolist() for name, pose in row.items()}


def test_a_good_goal_passes_for_both_arms():
    GOOD.check(panel(), fed(), PARAMETERS)
    GOOD.check(panel(), fed(FACING), PARAMETERS)


def test_the_path_lies_between_the_pins_at_equal_distances():
    assert places(GOOD) == {
        "pin_1": [0.0, -0.236],
        "path_1": [0.0, -0.136],
        "path_2": [0.0, -0.036],
        "path_3": [0.0, 0.064],
        "path_4": [0.0, 0.164],
        "pin_2": [0.0, 0.236],
    }


def test_a_row_that_is_not_centered_begins_at_the_origin_and_one_not_rotated_runs_along_x():
    assert places(goal(centered=False))["pin_1"] == [0.0, 0.0]
    assert places(goal(centered=False))["pin_2"] == [0.0, 0.472]
    assert places(goal(rotate=False))["pin_1"] == [-0.236, 0.0]
    assert places(goal(rotate=False))["path_1"] == [-0.136, 0.0]


def test_the_pins_point_out_of_the_wire():
    row = pin_row(GOOD, WIRE, panel())
    outward = row["pin_2"].position - row["pin_1"].position
    assert row["pin_2"].rotation[:, 0] @ outward > 0 > row["pin_1"].rotation[:, 0] @ outward
    assert all(math.isclose(pose.position[2], WIRE.radius) for pose in row.values())


def test_no_pose_of_the_path_falls_on_a_pin():
    row = pin_row(goal(path_space=0.472 / 3), WIRE, panel())
    assert list(row) == ["pin_1", "path_1", "path_2", "pin_2"]
    assert list(pin_row(goal(path_space=0.472), WIRE, panel())) == ["pin_1", "pin_2"]


def test_a_goal_for_one_robot_twice_is_never_born():
    with refused(Code.INVALID_GOAL, "it takes two robots"):
        goal(robot_2="robot_1")


@pytest.mark.parametrize(
    ("changes", "code", "words"),
    [
        ({"path_space": math.nan}, Code.INVALID_GOAL, "path_space is nan"),
        ({"path_space": -0.1}, Code.INVALID_GOAL, "allowed: 0.005 to 1 m"),
        ({"path_space": 0.5}, Code.INVALID_GOAL, "allowed: up to connector_space"),
        ({"connector_space": math.inf}, Code.INVALID_GOAL, "connector_space is inf"),
        ({"connector_space": 0.0}, Code.INVALID_GOAL, "allowed: 0.01 to 1 m"),
        ({"connector_space": 0.40}, Code.INVALID_GOAL, r"0.48 m long, allowed: 0.47 to 0.478 m"),
        ({"rotate": False}, Code.INVALID_GOAL, "pin_1 would lie beyond the plate"),
        ({"centered": False}, Code.INVALID_GOAL, "path_4 would lie beyond the plate"),
    ],
)
def test_a_row_that_the_wire_or_the_panel_does_not_allow_is_refused(changes, code, words):
    with refused(code, words):
        goal(**changes).check(panel(), fed(), PARAMETERS)


def test_pins_and_path_keep_clear_of_components():
    wide = dataclasses.replace(panel(), size=(0.55, 0.70, 0.003))
    crowded = with_first(wide, "components", pose=(-0.08, 0.0, 0.0))
    with pytest.raises(AbilityError, match=r"path_1 would lie .* to component 'X1'"):
        goal(rotate=False, path_space=0.15).check(crowded, fed(), PARAMETERS)


def test_there_must_be_a_live_wire_with_loose_ends():
    with refused(Code.WIRE_NOT_FED):
        GOOD.check(panel(), BeliefState(), PARAMETERS)
    belief = fed()
    belief.ends[WireEnd.A] = EndState.FIXED
    with pytest.raises(AbilityError, match="extract it first"):
        GOOD.check(panel(), belief, PARAMETERS)


def test_an_arm_that_does_not_reach_a_pin_is_reported():
    far = Arm(PANDA_AT_ORIGIN.model, (-0.8, 0.0, 0.0, 0.0))
    with refused(Code.UNREACHABLE):
        GOOD.check(panel(), fed(far), PARAMETERS)
    assert np.isfinite(GOOD.path_space)
