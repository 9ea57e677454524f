"""A driver follows timed postures evenly, and the newest ones in place of those before."""

import numpy as np
import pytest

from remodel_sim.ros.robot_driver import Setpoints

STEP_S = 0.01


def followed(points, steps, *, start=0.0):
    """Return where one joint is after each step, and the setpoints."""
    setpoints, at, now_s = Setpoints(), np.array([start]), 0.0
    for at_s, value in points:
        setpoints.add(at_s, np.array([value]))
    ways = []
    for _ in range(steps):
        there = setpoints.step(now_s, STEP_S, at)
        at = at if there is None else there
        ways.append(float(at[0]))
        now_s += STEP_S
    return ways


def test_a_posture_is_reached_evenly_when_it_is_due_and_kept():
    assert followed([(0.04, 4.0)], 6) == pytest.approx([1, 2, 3, 4, 4, 4])


def test_postures_are_reached_one_after_the_other():
    assert followed([(0.02, 2.0), (0.04, 6.0)], 4) == pytest.approx([1, 2, 4, 6])


def test_a_posture_that_is_due_between_two_steps_is_passed_through():
    assert followed([(0.015, 3.0), (0.03, 3.0)], 3) == pytest.approx([2, 3, 3])


def test_a_new_posture_replaces_what_was_due_later():
    assert followed([(0.02, 2.0), (0.04, 6.0), (0.03, 0.0)], 4) == pytest.approx([1, 2, 0, 0])


def test_what_is_overdue_is_reached_at_once():
    assert followed([(-0.01, 5.0)], 2) == pytest.approx([5, 5])


def test_a_way_begins_when_it_is_commanded_not_when_the_last_one_ended():
    setpoints, at = Setpoints(), np.array([0.0])
    setpoints.add(0.01, np.array([1.0]))
    at = setpoints.step(0.0, STEP_S, at)
    assert setpoints.step(0.01, STEP_S, at) is None
    setpoints.add(0.54, np.array([5.0]))
    assert setpoints.step(0.50, STEP_S, at) == pytest.approx([2.0])
