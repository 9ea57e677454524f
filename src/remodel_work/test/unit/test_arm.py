import math
from dataclasses import replace

import numpy as np
import pytest

from remodel_states.core.codes import Code
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.robot.arm import KUKA_IIWA, PANDA_AT_ORIGIN, Arm, ToolPose

IIWA = Arm(KUKA_IIWA, (-0.05, 0.02, 0.01, 0.1))
FACING_PANDA = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))
ON_AXIS = read_cell("cabinet").robots[0].arm
IIWA_ON_AXIS = replace(IIWA, axis=ON_AXIS.axis)
ARMS = pytest.mark.parametrize("arm", [PANDA_AT_ORIGIN, FACING_PANDA, IIWA, ON_AXIS, IIWA_ON_AXIS])


@ARMS
def test_joints_bring_the_tool_where_it_was_asked(arm):
    random = np.random.default_rng(0)
    for _ in range(200):
        asked = ToolPose(
            random.uniform(0.36, 0.64),
            random.uniform(-0.3, 0.3),
            random.uniform(0.0, 0.2),
            arm.base[3] + random.uniform(-1.2, 2.5),
        )
        joints = arm.joints_for(asked)
        found = arm.tool_of(joints)
        np.testing.assert_allclose(found.position, asked.position, atol=1e-9)
        assert math.isclose(math.cos(found.yaw - asked.yaw), 1.0)
        assert np.all(joints >= arm.limits[0]) and np.all(joints <= arm.limits[1])


@pytest.mark.parametrize(
    "tool", [ToolPose(1.2, 0, 0.1, 0), ToolPose(0.5, 0, 0.1, math.radians(-135))]
)
def test_what_the_arm_does_not_reach_is_said(tool):
    with pytest.raises(AbilityError, match="no arm posture reaches") as caught:
        PANDA_AT_ORIGIN.joints_for(tool)
    assert caught.value.code is Code.UNREACHABLE


def test_canonical_yaws_differ_by_the_turn_that_joint_7_makes():
    first = PANDA_AT_ORIGIN.canonical_yaw(0.5, 0.0, math.radians(-100))
    second = PANDA_AT_ORIGIN.canonical_yaw(0.5, 0.0, math.radians(200))
    assert math.isclose(math.degrees(second - first), 300.0)
    assert PANDA_AT_ORIGIN.canonical_yaw(0.5, 0.0, math.radians(-140)) is None
