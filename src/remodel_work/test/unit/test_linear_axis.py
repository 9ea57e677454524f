"""An arm on a linear axis: where the axis carries it, and what the cabinet reaches."""

import math
from itertools import combinations, product

import numpy as np
import pytest
from panels import panel

from remodel_work.cell.scrap_bin import bin_of
from remodel_work.edge.cell_file import read_cell
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import gap_between, volume_of

CELL, PAIR = read_cell("cabinet"), read_cell("two_arms_cabinet")
(ROBOT,) = CELL.robots
ARM = ROBOT.arm
ALONG_X, ALONG_Y = (0.0, 180.0), (90.0, -90.0)


def reached(x, y, z, yaws_deg, arm=ARM):
    """Return those of some directions of the hand that an arm reaches at a place [deg]."""
    return [yaw for yaw in yaws_deg if arm.reaches(ToolPose(x, y, z, math.radians(yaw)))]


@pytest.mark.parametrize("arm", [ARM, *PAIR.arms])
def test_the_cabinets_arms_reach_its_plate_with_the_hand_along_and_across_the_rails(arm):
    grid = product(np.linspace(0.25, 0.75, 11), np.linspace(-0.37, 0.37, 11), (0.01, 0.08, 0.15))
    for x, y, z in grid:
        for yaws in (ALONG_X, ALONG_Y):
            assert reached(x, y, z, yaws, arm) == list(yaws), (x, y, z)


def test_the_cabinet_reaches_the_magazines_strip_for_wires_along_either_direction():
    grid = product(np.linspace(0.12, 0.22, 6), np.linspace(-0.40, 0.40, 11), (0.01, 0.08, 0.15))
    for x, y, z in grid:
        assert reached(x, y, z, ALONG_X) == list(ALONG_X), (x, y, z)
        assert reached(x, y, z, ALONG_Y), (x, y, z)


@pytest.mark.parametrize("cell", [CELL, PAIR, read_cell("large_cabinet")])
def test_arms_at_home_are_apart_and_outside_of_the_overhead_picture(cell):
    volumes = [volume_of(robot.arm, robot.arm.joints_for(robot.home)) for robot in cell.robots]
    for volume in volumes:
        for point in (*volume.starts, *volume.ends):
            assert not any(view.sees(point[None], 0.0) for view in cell.overheads), point
    assert all(gap_between(*pair) > 0.5 for pair in combinations(volumes, 2))


def test_the_cabinet_reaches_its_scrap_bin_beside_the_plate():
    tool = bin_of(ROBOT, panel())
    assert ARM.reaches(tool) and abs(tool.y) > 0.37 + 0.05


def test_the_axis_keeps_the_tool_as_far_from_the_arm_as_the_arm_folds_and_within_its_travel():
    for x, y in product(np.linspace(0.0, 0.75, 31), np.linspace(-0.4, 0.4, 31)):
        travel = ARM.axis.position_for(x - ARM.base[0], y - ARM.base[1], ARM.near_m)
        assert ARM.axis.lower <= travel <= ARM.axis.upper
        if x >= 0.12:
            assert math.hypot(x - ARM.base[0], y - travel) > ARM.near_m - 0.01


def test_without_a_near_place_the_arm_reaches_straight_ahead():
    travel, azimuth = ARM.joints_for(ToolPose(0.70, 0.20, 0.1, 0.0))[:2]
    assert travel == pytest.approx(0.20, abs=0.01)
    assert azimuth == pytest.approx(0.0, abs=0.02)
