import math

import numpy as np

from remodel_work.robot.arm import PANDA_AT_ORIGIN, Arm, ToolPose
from remodel_work.robot.arm_volume import Volume, gap_between, volume_of

FACING = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))


def test_gaps_are_those_between_the_nearest_points():
    def segment(start, end, radius):
        return Volume(np.array([start]), np.array([end]), np.array([radius]))

    level = segment([0.0, 0, 0], [1.0, 0, 0], 0.1)
    cases = [
        (segment([0.5, -1, 0.5], [0.5, 1, 0.5], 0.1), 0.3),  # crossing above
        (segment([1.3, 0, 0.4], [1.3, 0, 0.4], 0.0), 0.4),  # a point beyond the end
        (segment([0.0, 0.3, 0], [1.0, 0.3, 0], 0.1), 0.1),  # parallel
        (segment([0.2, 0, -1], [0.2, 0, 1], 0.05), -0.15),  # through
    ]
    for other, gap in cases:
        assert math.isclose(gap_between(level, other), gap, abs_tol=1e-9)
        assert math.isclose(gap_between(other, level), gap, abs_tol=1e-9)


def test_an_arm_at_home_is_clear_of_the_other_at_work():
    home = FACING.joints_for(ToolPose(0.98, 0.46, 0.35, math.pi / 2))
    work = PANDA_AT_ORIGIN.joints_for(ToolPose(0.50, 0.20, 0.03, 0.0))
    assert gap_between(volume_of(FACING, home), volume_of(PANDA_AT_ORIGIN, work)) > 0.1
