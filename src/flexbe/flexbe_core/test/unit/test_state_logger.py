"""The record of a behavior: what is in its lines."""

import logging

import pytest
import rospy
import yaml

from flexbe_core import EventState, OperatableStateMachine, StateLogger
from flexbe_core.engine.engine import Engine
from flexbe_core.engine.supervision import Ended
from flexbe_core.state_logger import (
    RunLogFile,
    YamlFormatter,
    _file_name,
    _merged,
    _serializer,
    log_all_events,
)
from flexbe_core.testing import ScriptedState


@pytest.fixture
def lines(monkeypatch):
    """Record in memory; return the lines so far, parsed."""
    written = []

    class Memory(logging.Handler):
        def emit(self, record):
            written.extend(yaml.safe_load(YamlFormatter().format(record)))

    handler, logger = Memory(), logging.getLogger("flexbe")
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG)
    logger.propagate = False
    monkeypatch.setattr(StateLogger, "enabled", True)
    yield written
    logger.removeHandler(handler)


def run(state):
    machine = OperatableStateMachine(outcomes=["finished"])
    machine.userdata.part = {"pin": 7}
    with machine:
        OperatableStateMachine.add("Work", state, {"done": "finished"})
    engine = Engine(machine)
    engine.recording = True
    engine.begin()
    assert engine.run(0.0) == "finished"
    return engine


def test_events_are_recorded_with_what_the_state_is(lines):
    state = ScriptedState()
    log_all_events(state)
    engine = run(state)
    events = [line for line in lines if line["logger"] == "flexbe.events"]
    assert [line["event"] for line in events] == ["enter", "exit"]
    assert events[0].keys() == {
        *("event", "duration", "name", "state", "path", "logger", "loglevel", "time")
    }
    assert (events[0]["name"], events[0]["state"]) == ("Work", "ScriptedState")
    assert events[0]["path"] == "/Work"
    assert Ended("/Work", "done") in engine.take_events()


def test_a_state_that_goes_on_in_another_version_is_recorded_once(lines):
    state = ScriptedState()
    log_all_events(state)
    log_all_events(state)
    run(state)
    assert [line["event"] for line in lines if "event" in line] == ["enter", "exit"]


def test_userdata_is_recorded_at_debug_level(lines):
    class Reading(ScriptedState):
        def __init__(self):
            super().__init__(input_keys=["part"])

    state = Reading()
    log_all_events(state)
    run(state)
    found = [line["userdata"] for line in lines if line["logger"] == "flexbe.userdata"]
    assert found == [{"part": {"pin": 7}}] * 2


def test_users_may_decorate_their_states(lines):
    @StateLogger.log_events("mine.events", begin="on_enter")
    @StateLogger.log_outcomes("flexbe.mine")
    @StateLogger.log_userdata("flexbe.data", keys=["part"])
    class Mine(EventState):
        def __init__(self):
            super().__init__(outcomes=["done"], input_keys=["part"])

        def execute(self, userdata):
            return "done"

    run(Mine())
    assert [line["outcome"] for line in lines if line["logger"] == "flexbe.mine"] == ["done"]
    assert [line["userdata"] for line in lines if line["logger"] == "flexbe.data"]


def test_nothing_is_recorded_unless_it_is_switched_on(lines, monkeypatch):
    monkeypatch.setattr(StateLogger, "enabled", False)
    state = ScriptedState()
    log_all_events(state)
    run(state)
    assert lines == []


def test_a_full_disk_ends_the_run_log_and_not_the_run(monkeypatch):
    reports = []
    monkeypatch.setattr(rospy, "logerr", lambda text, *words: reports.append(text % words))
    handler, logger = RunLogFile("/dev/full"), logging.getLogger("flexbe")
    handler.setFormatter(YamlFormatter())
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG)
    monkeypatch.setattr(StateLogger, "enabled", True)
    state = ScriptedState()
    log_all_events(state)
    run(state)
    StateLogger.shutdown()
    assert len(reports) == 1
    assert "/dev/full ends here, and the behavior runs on without it" in reports[0]
    assert "No space left on device" in reports[0]


def test_a_text_of_several_lines_takes_one_line_of_the_log():
    about = {"userdata": {"text": "two\nlines", "bytes": b"1" * 99, "long": "a b " * 9999}}
    record = logging.LogRecord("flexbe.userdata", logging.DEBUG, "", 0, about, None, None)
    line = YamlFormatter().format(record)
    assert len(line.splitlines()) == 1
    (found,) = yaml.safe_load(line)
    assert found["userdata"] == about["userdata"]


@pytest.mark.parametrize(
    "parameters",
    [{"~log_config": "text"}, {"~log_folder": "~nobody_here/logs"}, {"~log_serialize": ["yaml"]}],
)
def test_a_behavior_runs_without_a_log_where_its_parameters_are_wrong(
    monkeypatch, tmp_path, parameters
):
    given, reports = {"~log_enabled": True, "~log_folder": str(tmp_path), **parameters}, []
    monkeypatch.setattr(rospy.core, "is_initialized", lambda: True)
    monkeypatch.setattr(rospy, "get_param", given.get)
    monkeypatch.setattr(rospy, "logerr", lambda text, *words: reports.append(text % words))
    StateLogger.initialize("Quick", 0)
    assert not StateLogger.enabled
    assert "no run log of Quick is written" in reports[0]


def test_files_are_named_after_the_behavior():
    assert _file_name("Place, Pin v1.2/b").startswith("place__pin_v1_2_b_")


def test_a_configuration_is_merged_over_the_default():
    merged = _merged({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"c": 4}, "e": 5})
    assert merged == {"a": {"b": 1, "c": 4}, "d": 3, "e": 5}


def test_an_unknown_way_to_write_values_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match=r"one of yaml, str, repr, pickle; found 'os\.system'"):
        _serializer("os.system")
