"""The capsules that stand for an arm, against its meshes."""

import math

import numpy as np
import pytest

from remodel_sim.physics.robot import Robot
from remodel_sim.physics.world import World
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.robot.arm import KUKA_IIWA, PANDA_AT_ORIGIN, Arm, ToolPose
from remodel_work.robot.arm_volume import Volume, gaps_between, volume_of

FACING = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))
ON_AXIS = read_cell("cabinet").robots[0].arm
IIWA = Arm(KUKA_IIWA, (-0.10, 0.0, 0.0, 0.0))


def reachable(arm, random):
    while True:
        tool = ToolPose(
            random.uniform(0.3, 0.7),
            random.uniform(-0.45, 0.45),
            random.uniform(0.0, 0.35),
            arm.base[3] + random.uniform(-1.5, 1.5),
        )
        if arm.reaches(tool):
            return tool


def surface(world, body):
    """Yield points of a body's collision shapes, (n, 3) [m], world frame."""
    bullet = world.bullet
    for link in range(-1, bullet.getNumJoints(body)):
        for shape in bullet.getCollisionShapeData(body, link):
            if link < 0:
                place = bullet.getBasePositionAndOrientation(body)
            else:
                place = bullet.getLinkState(body, link, computeForwardKinematics=True)[:2]
            if shape[2] == bullet.GEOM_BOX:
                place = bullet.multiplyTransforms(*place, shape[5], shape[6])
                corners = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
                points = corners * shape[3]
            else:
                points = np.array(bullet.getMeshData(body, link)[1])
            yield Pose(*(np.array(part) for part in place)).apply(points)


@pytest.mark.parametrize("arm", [PANDA_AT_ORIGIN, FACING, IIWA, ON_AXIS])
def test_the_capsules_hold_the_whole_arm(arm):
    random = np.random.default_rng(3)
    world = World(240)
    for _ in range(6):
        world.clear()
        tool = reachable(arm, random)
        robot = Robot(world, tool, arm)
        capsules = volume_of(arm, arm.joints_for(tool))
        points = np.concatenate(list(surface(world, robot.body)))
        dots = Volume(points, points, np.zeros(len(points)))
        outside = gaps_between(dots, capsules).min(axis=1)
        assert outside.max() < 0.0, "a point of the arm is outside of its capsules"
    world.close()
