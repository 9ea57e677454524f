"""Force control of pushes and pulls: its law, on springs."""

import numpy as np
import pytest
from scripted_device import PARAMETERS

from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.force_control import ForceControl, Yielding

SPEED = 0.02


def control_of(limit):
    return ForceControl(limit, PARAMETERS.wire.grip_stiffness_n_m, PARAMETERS.motion)


def peak_at_a_spring(stiffness, limit, rate_hz, free_m=0.01, seconds=4.0):
    """Return the largest force on a spring that is met at full speed, and the last one [N]."""
    control, travel, speed, peak, force = control_of(limit), 0.0, 0.0, 0.0, 0.0
    for _ in range(round(seconds * rate_hz)):
        speed = control.speed(SPEED, force, speed, 1 / rate_hz)
        travel += speed / rate_hz
        force = stiffness * max(0.0, travel - free_m)
        peak = max(peak, force)
    return peak, force


@pytest.mark.parametrize("rate_hz", [240.0, 500.0])
@pytest.mark.parametrize("limit", [4.0, 8.0, 25.0])
@pytest.mark.parametrize("stiffness", [5e3, 2e4, 6e4])
def test_a_push_comes_to_its_limit_and_not_beyond_whatever_stops_it(stiffness, limit, rate_hz):
    peak, last = peak_at_a_spring(stiffness, limit, rate_hz)
    assert limit <= last <= peak <= 1.15 * limit


def test_a_push_that_is_over_its_limit_goes_back():
    assert control_of(8.0).speed(SPEED, 9.0, SPEED, 1 / 240) < 0


def test_a_push_does_not_jerk_the_hand_forwards():
    assert control_of(25.0).speed(SPEED, 0.0, 0.0, 1 / 240) <= 0.3 / 240 + 1e-12


MOTION = read_parameters().parameters.motion
STEP_S = 1 / 240


def test_it_gives_way_against_the_force_no_faster_than_the_arm_speeds_up():
    yielding = Yielding(np.eye(3)[:2], np.array([0.001, 0.004]), stiffness=1e3)
    free = yielding.speeds(np.zeros(2), np.zeros(2), STEP_S, MOTION)
    pushed = yielding.speeds(np.array([-1.0, 0.01]), np.zeros(2), STEP_S, MOTION)
    np.testing.assert_allclose(free, 0.0)
    assert pushed[0] == pytest.approx(MOTION.force_acceleration_m_s2 * STEP_S)
    assert -MOTION.force_acceleration_m_s2 * STEP_S < pushed[1] < 0.0
