import math

import numpy as np
from scripted_device import PARAMETERS

from remodel_skills.motion import Line
from remodel_skills.space import Traffic
from remodel_work.robot.arm import PANDA_AT_ORIGIN, Arm, ToolPose
from remodel_work.robot.arm_volume import volume_of

MOTION = PARAMETERS.motion
FACING = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))
HOME = ToolPose(0.98, 0.46, 0.35, math.pi / 2)


def standing(arm, x, y, z=0.10):
    return volume_of(arm, arm.joints_for(ToolPose(x, y, z, math.pi / 2)))


def along(arm, start, end):
    return volume_of(arm, Line(start, end, 0.1, MOTION).postures(arm))


def test_free_room_is_given():
    traffic = Traffic(MOTION.robots_apart_m)
    traffic.stand("robot_2", volume_of(FACING, FACING.joints_for(HOME)))
    assert traffic.claim("robot_1", standing(PANDA_AT_ORIGIN, 0.5, -0.2)) is None


def test_a_path_past_another_robot_names_it_and_claims_nothing():
    traffic = Traffic(MOTION.robots_apart_m)
    traffic.stand("robot_1", standing(PANDA_AT_ORIGIN, 0.45, -0.25))
    traffic.stand("robot_2", standing(FACING, 0.55, 0.05))
    start, end = ToolPose(0.45, -0.25, 0.1, 0.0), ToolPose(0.45, 0.30, 0.1, 0.0)
    before = traffic.claims["robot_1"]
    assert traffic.claim("robot_1", along(PANDA_AT_ORIGIN, start, end)) == "robot_2"
    assert traffic.claims["robot_1"] is before


def test_a_claimed_path_is_kept_from_others_until_its_robot_stands():
    traffic = Traffic(MOTION.robots_apart_m)
    start, end = ToolPose(0.45, -0.25, 0.1, 0.0), ToolPose(0.45, 0.30, 0.1, 0.0)
    assert traffic.claim("robot_1", along(PANDA_AT_ORIGIN, start, end)) is None
    wanted = standing(FACING, 0.55, -0.10)
    assert traffic.claim("robot_2", wanted) == "robot_1"
    traffic.stand("robot_1", standing(PANDA_AT_ORIGIN, end.x, end.y))
    assert traffic.claim("robot_2", wanted) is None


def test_a_lines_postures_begin_and_end_where_it_does():
    start, end = ToolPose(0.45, -0.2, 0.1, 0.0), ToolPose(0.5, 0.2, 0.05, 0.5)
    postures = Line(start, end, 0.2, MOTION).postures(PANDA_AT_ORIGIN)
    np.testing.assert_allclose(PANDA_AT_ORIGIN.tool_of(postures[0]).position, start.position)
    np.testing.assert_allclose(PANDA_AT_ORIGIN.tool_of(postures[-1]).position, end.position)
    assert np.abs(np.diff(postures, axis=0)).max() < 0.15
