"""When a node reports that simulated time has stopped."""

import rospy

from flexbe_core import OperatableStateMachine
from flexbe_core.engine.definitions import DEFAULT_PERIOD_S
from flexbe_core.ros.clock import Standstill
from flexbe_core.ros.session import Session


def reports(readings):
    standstill = Standstill()
    return [
        (wall_s, text) for ros_s, wall_s in readings if (text := standstill.reading(ros_s, wall_s))
    ]


def test_a_node_without_a_clock_reports_it_once():
    ((at_s, text),) = reports([(0.0, float(wall_s)) for wall_s in range(100, 130)])
    assert at_s == 105.0
    assert text.startswith("/use_sim_time is true, and no node publishes /clock: this node waits")


def test_each_standstill_of_a_clock_is_reported_once():
    running = [(float(s), float(s)) for s in range(1, 50)]
    stopped = [(49.0, float(s)) for s in range(50, 70)]
    again = [(s - 20.0, float(s)) for s in range(70, 80)]
    stopped_again = [(59.0, float(s)) for s in range(80, 90)]
    found = reports([*running, *stopped, *again, *stopped_again])
    assert [at_s for at_s, _ in found] == [54.0, 84.0]
    assert "/clock has stopped at 49.0 s" in found[0][1]


def test_a_clock_that_runs_slowly_or_jumps_back_is_no_standstill():
    assert not reports([(0.01 * s, float(s)) for s in range(1, 60)])
    assert not reports([(float(s % 4), float(s)) for s in range(60)])


def test_what_is_never_due_sleeps_for_a_period(monkeypatch):
    slept, session = [], Session(OperatableStateMachine(outcomes=["finished"]))
    monkeypatch.setattr(rospy, "sleep", slept.append)
    monkeypatch.setattr(session.engine, "next_due", lambda: float("inf"))
    session.sleep()
    assert slept == [DEFAULT_PERIOD_S]
