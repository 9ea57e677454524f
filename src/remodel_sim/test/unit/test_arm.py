"""An arm's closed form against the physics engine."""

import math
from dataclasses import replace

import numpy as np
import pytest

from remodel_sim.physics.robot import Robot
from remodel_sim.physics.world import World
from remodel_work.edge.cell_file import read_cell
from remodel_work.robot.arm import KUKA_IIWA, PANDA_AT_ORIGIN, Arm, ToolPose

IIWA = Arm(KUKA_IIWA, (-0.05, 0.02, 0.01, 0.1))
FACING_PANDA = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))
ON_AXIS = read_cell("cabinet").robots[0].arm
IIWA_ON_AXIS = replace(IIWA, axis=ON_AXIS.axis)
ARMS = pytest.mark.parametrize("arm", [PANDA_AT_ORIGIN, FACING_PANDA, IIWA, ON_AXIS, IIWA_ON_AXIS])


@pytest.mark.physics
def test_where_a_moving_arm_is_does_not_follow_from_who_has_looked():
    world = World(240)
    robot = Robot(world, ToolPose(0.5, 0.0, 0.1, 0.0), PANDA_AT_ORIGIN)
    robot.drive(robot.joints + 0.1, steps=20)
    for _ in range(10):
        world.step()
    boxes = robot.boxes()
    assert robot.world_from_hand is not None
    np.testing.assert_array_equal(robot.boxes(), boxes)
    world.close()


@ARMS
def test_the_closed_form_agrees_with_the_physics_engine(arm):
    world = World(240)
    asked = ToolPose(0.52, -0.17, 0.05, arm.base[3] + 1.1)
    hand = Robot(world, asked, arm).world_from_hand
    tool = hand.apply(np.array([0.0, 0.0, arm.fingers.tool_m]))
    np.testing.assert_allclose(tool, asked.position, atol=1e-6)
    assert math.isclose(math.cos(hand.yaw - asked.yaw), 1.0, abs_tol=1e-9)
    np.testing.assert_allclose(hand.rotation[:, 2], [0, 0, -1], atol=1e-6)
    world.close()
