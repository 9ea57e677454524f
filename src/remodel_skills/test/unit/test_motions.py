"""Straight lines as motions of all joints, and how a hand holds the wire that it turns."""

import math
from itertools import product

import numpy as np
import pytest

from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.motion import Line
from remodel_skills.primitives.motions import choose_flip
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import wrap_angle
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import PANDA_FINGERS
from remodel_work.robot.portal import Portal

PORTAL = Portal((0.5, 0.0, 0.0, math.pi / 2), (-0.4, -0.6, 0.0), (0.4, 0.6, 0.9), PANDA_FINGERS)


@pytest.mark.parametrize("then_yaw", [math.pi, 0.0, math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("tip_yaw", [math.pi / 2, -math.pi / 2, 3.0])
def test_a_wire_is_held_so_that_the_hand_turns_it_the_short_way(tip_yaw, then_yaw):
    flip = choose_flip(PORTAL, (0.3, 0.1), tip_yaw, (0.6, 0.1), then_yaw)
    first = wrap_angle(tip_yaw - flip)
    turned = first + wrap_angle(then_yaw - tip_yaw)
    assert PORTAL.canonical_yaw(0.6, 0.1, turned) == pytest.approx(turned)
    assert math.remainder(turned + flip - then_yaw, 2 * math.pi) == pytest.approx(0.0)


MOTION = read_parameters().parameters.motion
CELL, PAIR = read_cell("cabinet"), read_cell("two_arms_cabinet")
(ROBOT,) = CELL.robots
ARM = ROBOT.arm
TICK_S = 1 / 120


def postures(line):
    """Return the postures of a motion at every tick, (n, joints)."""
    ticks = range(math.ceil(line.duration / TICK_S) + 1)
    return np.array([ARM.joints_for(line.at(tick * TICK_S)) for tick in ticks])


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
