"""What the contract fixes: times, limits of a cell, and how the time of a goal is measured."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from remodel_states.core import contract
from remodel_states.core.contract import RosStopwatch, beyond_limit, limits_of
from remodel_states.core.tables import TableError

README = Path(__file__).parents[3] / "remodel_msgs" / "README.md"


def test_the_readme_states_each_time():
    rows = re.findall(r"^\| .* \| ([0-9.]+) s \| .* \|$", README.read_text(), re.MULTILINE)
    times = {
        name: value for name, value in vars(contract).items() if re.fullmatch("[A-Z].*_S", name)
    }
    assert sorted(map(float, rows)) == sorted(times.values())


TABLE = {"force_limit": 25, "speed_m_s": 0.25, "InsertCable": {"force_limit": 20.0}}


def test_the_lower_limit_holds():
    assert limits_of("InsertCable", TABLE) == {"force_limit": 20.0, "speed_m_s": 0.25}
    assert limits_of("PlaceConnector", TABLE) == {"force_limit": 25.0, "speed_m_s": 0.25}
    assert limits_of("InsertCable", {**TABLE, "InsertCable": {"force_limit": 90}}) == {
        "force_limit": 25.0,
        "speed_m_s": 0.25,
    }
    assert limits_of("InsertCable", {}) == {}


def test_a_goal_beyond_a_limit_is_named_with_both_values():
    limits = limits_of("InsertCable", TABLE)
    assert beyond_limit(SimpleNamespace(force_limit=20.0), limits) == ""
    assert beyond_limit(SimpleNamespace(id="x"), limits) == ""
    for force in (20.5, -20.5):
        said = beyond_limit(SimpleNamespace(force_limit=force), limits)
        assert said.startswith(f"force_limit is {force:g}, at most 20 is allowed in this cell")


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ([1], r"\[1\] found; needed: {NAME: NUMBER}"),
        ({"InsertCable": 3}, "InsertCable: 3 found; needed: {NAME: NUMBER}"),
        ({"force_limit": "25"}, "force_limit: '25' found; needed: a number above 0"),
        ({"InsertCable": {"force_limit": 0}}, "InsertCable.force_limit: 0 found"),
        ({"force_limit": True}, "force_limit: True found"),
    ],
)
def test_a_malformed_table_is_refused_with_the_place(document, said):
    with pytest.raises(TableError, match=said):
        limits_of("InsertCable", document)


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


def test_a_limit_beyond_all_numbers_is_refused():
    with pytest.raises(TableError, match="needed: a number above 0"):
        limits_of("InsertCable", {"force_limit": 10**400})
