"""The kinematics of a portal."""

import math

import numpy as np
import pytest
from refusals import refused

from remodel_states.core.codes import Code
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import PANDA_FINGERS
from remodel_work.robot.portal import Portal

PORTAL = Portal((0.5, 0.0, 0.0, math.pi / 2), (-0.4, -0.6, 0.0), (0.4, 0.6, 0.9), PANDA_FINGERS)


@pytest.mark.parametrize(
    "tool", [ToolPose(0.5, 0.0, 0.1, 0.0), ToolPose(0.2, 0.3, 0.8, 4.0), ToolPose(0.9, -0.3, 0, -1)]
)
def test_joints_bring_the_tool_where_they_were_asked_for(tool):
    again = PORTAL.tool_of(PORTAL.joints_for(tool))
    assert np.allclose(again.position, tool.position)
    assert math.remainder(again.yaw - tool.yaw, 2 * math.pi) == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("tool", "joint"),
    [
        (ToolPose(0.5, 0.5, 0.1, 0.0), "portal_x"),
        (ToolPose(1.2, 0.0, 0.1, 0.0), "portal_y"),
        (ToolPose(0.5, 0.0, 1.0, 0.0), "portal_z"),
    ],
)
def test_a_place_out_of_reach_is_refused_with_the_joint(tool, joint):
    with refused(Code.UNREACHABLE, f"{joint} would stand at .*, allowed"):
        PORTAL.joints_for(tool)
    assert not PORTAL.reaches(tool)


def test_a_hand_leads_a_wire_around_three_corners():
    yaws = [PORTAL.base[3] + 0.75 * math.pi - turn for turn in np.linspace(0, 1.5 * math.pi, 7)]
    assert [PORTAL.canonical_yaw(0.5, 0.0, yaw) for yaw in yaws] == pytest.approx(yaws)
