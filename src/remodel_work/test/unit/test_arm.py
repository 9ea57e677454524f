"""Arms: postures, where a linear axis carries one, what the cabinet reaches, and volumes."""

import math
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from panels import panel
from refusals import refused

from remodel_states.core.codes import Code
from remodel_work.cell.cell_design import bin_of
from remodel_work.edge.cell_file import read_cell
from remodel_work.robot.arm import KUKA_IIWA, PANDA_AT_ORIGIN, Arm, ToolPose
from remodel_work.robot.arm_volume import Volume, gap_between, volume_of

IIWA = Arm(KUKA_IIWA, (-0.05, 0.02, 0.01, 0.1))
FACING_PANDA = Arm(PANDA_AT_ORIGIN.model, (1.0, 0.0, 0.0, math.pi))
CELL, PAIR = read_cell("cabinet"), read_cell("two_arms_cabinet")
(ROBOT,) = CELL.robots
ARM = ROBOT.arm
IIWA_ON_AXIS = replace(IIWA, axis=ARM.axis)
ARMS = pytest.mark.parametrize("arm", [PANDA_AT_ORIGIN, FACING_PANDA, IIWA, ARM, IIWA_ON_AXIS])


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
    with refused(Code.UNREACHABLE, "no arm posture reaches"):
        PANDA_AT_ORIGIN.joints_for(tool)


def test_canonical_yaws_differ_by_the_turn_that_joint_7_makes():
    first = PANDA_AT_ORIGIN.canonical_yaw(0.5, 0.0, math.radians(-100))
    second = PANDA_AT_ORIGIN.canonical_yaw(0.5, 0.0, math.radians(200))
    assert math.isclose(math.degrees(second - first), 300.0)
    assert PANDA_AT_ORIGIN.canonical_yaw(0.5, 0.0, math.radians(-140)) is None


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
    home = FACING_PANDA.joints_for(ToolPose(0.98, 0.46, 0.35, math.pi / 2))
    work = PANDA_AT_ORIGIN.joints_for(ToolPose(0.50, 0.20, 0.03, 0.0))
    assert gap_between(volume_of(FACING_PANDA, home), volume_of(PANDA_AT_ORIGIN, work)) > 0.1
