"""Only ROS time that a simulation can produce counts, however its clock jumps."""

import pytest

from remodel_states.core.contract import RosStopwatch


def elapsed(readings):
    """Return what a stopwatch reads at the last of these (ROS, wall) times, begun at the first."""
    ros, wall = zip(*readings, strict=True)
    watch = RosStopwatch(iter(ros).__next__, iter(wall).__next__)
    return [watch.read() for _ in readings[1:]][-1]


@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("poll_s", [0.004, 0.1])
def test_any_speed_of_a_simulation_is_measured(speed, poll_s):
    readings = [(1000.0 + speed * poll_s * n, poll_s * n) for n in range(101)]
    assert elapsed(readings) == pytest.approx(100 * speed * poll_s)


def test_a_clock_of_coarse_steps_is_measured():
    readings = [(float(n // 25), 0.004 * n) for n in range(251)]  # steps of 1 s, ten times as fast
    assert elapsed(readings) == pytest.approx(10.0)


@pytest.mark.parametrize("jump_s", [-1e9, -100.0, -0.5, 30.0, 1000.0, 1e9])
def test_a_jump_does_not_count(jump_s):
    before = [(50.0 + 0.1 * n, 0.1 * n) for n in range(10)]
    after = [(50.0 + jump_s + 0.1 * n, 0.1 * n) for n in range(10, 20)]
    assert elapsed(before + after) == pytest.approx(1.8)


def test_a_jump_of_a_clock_that_was_stopped_does_not_count():
    stopped = [(50.0, 0.1 * n) for n in range(100)]
    assert elapsed([*stopped, (150.0, 10.0), (150.1, 10.1)]) == pytest.approx(0.1)
