"""When an execution counts as a hang."""

from flexbe_onboard.run_watch import REPORT_AGAIN_S, HangAlarm


def test_a_hang_is_reported_once_and_again_later():
    alarm = HangAlarm(2.0)
    assert alarm.check(10.0, 11.9) is None
    assert alarm.check(10.0, 12.0) == 2.0
    assert alarm.check(10.0, 13.0) is None
    assert alarm.check(10.0, 12.0 + REPORT_AGAIN_S) == 2.0 + REPORT_AGAIN_S


def test_each_execution_has_its_own_limit():
    alarm = HangAlarm(2.0)
    assert alarm.check(10.0, 13.0) == 3.0
    assert alarm.check(None, 14.0) is None
    assert alarm.check(15.0, 16.0) is None
    assert alarm.check(15.0, 18.0) == 3.0


def test_without_a_limit_nothing_hangs():
    assert HangAlarm(0.0).check(0.0, 1e6) is None
