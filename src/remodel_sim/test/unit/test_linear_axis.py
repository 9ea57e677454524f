"""An arm on a linear axis: where the axis carries it, how it moves, what the cabinet reaches."""

import math
from itertools import combinations, product

import numpy as np
import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.motion import Line
from remodel_skills.primitives.motions import choose_flip, move_to, park
from remodel_work.cell.scrap_bin import bin_of
from remodel_work.edge.cell_file import read_cell
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import gap_between, volume_of

MOTION = read_parameters().parameters.motion

CELL, PAIR = read_cell("cabinet"), read_cell("two_arms_cabinet")
(ROBOT,) = CELL.robots
ARM = ROBOT.arm
ALONG_X, ALONG_Y = (0.0, 180.0), (90.0, -90.0)
TICK_S = 1 / 120


def postures(line):
    """Return the postures of a motion at every tick, (n, joints)."""
    ticks = range(math.ceil(line.duration / TICK_S) + 1)
    return np.array([ARM.joints_for(line.at(tick * TICK_S)) for tick in ticks])


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


@pytest.mark.parametrize("cell", [CELL, PAIR])
def test_arms_at_home_are_apart_and_outside_of_the_overhead_picture(cell):
    volumes = [volume_of(robot.arm, robot.arm.joints_for(robot.home)) for robot in cell.robots]
    for volume in volumes:
        for point in (*volume.starts, *volume.ends):
            assert not cell.overhead.sees(point[None], margin_px=0.0), point
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


@pytest.mark.parametrize(
    ("start", "end"),
    [
        (ToolPose(0.15, -0.40, 0.1, math.pi / 2), ToolPose(0.70, 0.37, 0.1, math.pi / 2)),
        (ToolPose(0.25, -0.37, 0.1, 0.0), ToolPose(0.25, 0.37, 0.1, 0.0)),
        (ToolPose(0.12, 0.40, 0.1, 0.0), ToolPose(0.75, 0.40, 0.02, 0.0)),
        (ROBOT.home, ToolPose(0.50, 0.30, 0.1, math.pi / 2)),
    ],
)
def test_a_straight_line_is_a_smooth_motion_within_the_limits_of_all_joints(start, end):
    line = Line(start, end, MOTION.free_speed_m_s, MOTION).paced(ARM)
    joints = postures(line)
    lower, higher = ARM.limits
    assert np.all((joints >= lower) & (joints <= higher))
    rates = np.abs(np.diff(joints, axis=0)).max(axis=0) / TICK_S
    assert np.all(rates <= ARM.speeds * 1.02), rates
    jumps = np.abs(np.diff(joints, 2, axis=0)).max(axis=0) / TICK_S**2
    assert np.all(jumps < np.array([5.0, *[20.0] * 7])), jumps
    for tick, posture in enumerate(joints):
        at = ARM.tool_of(posture)
        np.testing.assert_allclose(at.position, line.at(tick * TICK_S).position, atol=1e-9)


@pytest.mark.parametrize("distance", [0.01, 0.06, 0.5])
def test_no_motion_speeds_up_faster_than_arms_allow(distance):
    line = Line(
        ToolPose(0.5, 0.0, 0.1, 0.0),
        ToolPose(0.5, 0.0, 0.1 + distance, 0.0),
        MOTION.free_speed_m_s,
        MOTION,
    )
    times = np.linspace(0.0, line.duration, 1001)
    heights = np.array([line.at(time).z for time in times])
    steepest = np.abs(np.diff(heights, 2)).max() / (times[1] - times[0]) ** 2
    assert steepest <= MOTION.acceleration_m_s2 * 1.01
    assert steepest > 0.2 * MOTION.acceleration_m_s2, "no slower than it needs to be"


def test_a_slow_axis_slows_the_motion_that_needs_it():
    start, end = ToolPose(0.5, -0.3, 0.1, 0.0), ToolPose(0.5, 0.3, 0.1, 0.0)
    line = Line(start, end, 2.0, MOTION)
    rates = np.abs(np.diff(postures(line.paced(ARM))[:, 0])) / TICK_S
    assert line.paced(ARM).duration > line.duration
    assert rates.max() == pytest.approx(ARM.axis.speed, rel=0.05)


@pytest.mark.physics
def test_the_simulated_arm_follows_with_its_axis_and_goes_home():
    cell = Cell(SimulatedPlant(panel(), design=read_cell("cabinet")))
    context, robot = cell.context, cell.plant.robots["robot_1"]
    target = ToolPose(0.60, 0.35, 0.10, 0.0)
    cell.run(move_to(context, target, MOTION.free_speed_m_s))
    np.testing.assert_allclose(robot.tool.position, target.position, atol=1e-3)
    names = dict(zip(robot.joint_names, robot.joint_state[0], strict=True))
    assert names["axis"] == pytest.approx(0.35, abs=0.02)
    base = robot.world_from_base.position
    np.testing.assert_allclose(base, [ARM.base[0], names["axis"], 0.0], atol=1e-6)
    cell.run(park(context))
    np.testing.assert_allclose(robot.tool.position, ROBOT.home.position, atol=1e-3)
    cell.close()


def test_the_cabinet_turns_a_wire_from_anywhere_in_the_magazine_into_any_terminal_of_the_plate():
    places = product((0.12, 0.16, 0.22), (-0.40, 0.0, 0.40), (math.pi / 2, -math.pi / 2, 0.0))
    for x, y, tip_yaw in places:
        for to_x, to_y, socket_yaw in product((0.25, 0.75), (-0.37, 0.37), (0.0, math.pi)):
            flip = choose_flip(ARM, (x, y), tip_yaw, (to_x, to_y), socket_yaw)
            start = ARM.canonical_yaw(x, y, tip_yaw - flip)
            end = ARM.canonical_yaw(to_x, to_y, socket_yaw - flip)
            line = Line(
                ToolPose(x, y, 0.12, start),
                ToolPose(to_x, to_y, 0.12, end),
                MOTION.free_speed_m_s,
                MOTION,
            )
            arrived = ARM.tool_of(line.postures(ARM)[-1])
            np.testing.assert_allclose(arrived.position, line.end.position, atol=1e-9)
