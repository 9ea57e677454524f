"""Goals that are rejected whatever the ability, and how goals end, without a ROS master."""

from math import inf
from threading import Event

import pytest
from actionlib_msgs.msg import GoalID, GoalStatus
from remodel_msgs.msg import DiscardCableGoal, ErrorCode

from remodel_states.ability_server import AbilityServer, Done
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.parameters import panel_pose
from remodel_states.serving import RunningGoal, why_late
from remodel_states.testing import serve_all


@pytest.mark.parametrize(
    ("sent_s", "timeout_s", "is_late"),
    [
        (1000.0, 60.0, False),
        (994.5, 60.0, False),
        (993.9, 60.0, True),
        (996.9, 2.0, True),
        (1005.0, 2.0, False),  # by a clock that is ahead, or after a jump back
        (0.0, 60.0, False),  # by a client that gives no time
    ],
)
def test_a_goal_that_its_client_has_given_up_is_late(sent_s, timeout_s, is_late):
    assert bool(why_late(sent_s, 1000.0, timeout_s)) == is_late


def test_the_reason_states_how_late_and_what_to_do():
    reason = why_late(940.0, 1000.0, 60.0)
    assert reason.startswith("sent 60.0 s ago, so its client has given it up; allowed: 6 s")
    assert "clocks of the two machines differ" in reason


class Handle:
    """Takes the end of a goal as actionlib's handle does."""

    def __init__(self):
        self.result = None

    def get_goal(self):
        return DiscardCableGoal(id="1:W1", timeout=10.0)

    def set_aborted(self, result, text):
        self.result = result


def test_findings_of_an_ability_that_this_one_made_use_of_are_left_out():
    handle = Handle()
    RunningGoal(read_abilities()["DiscardCable"], handle, elapsed=lambda: 2.0).fail(
        ErrorCode.EXTRACTION_STUCK, "stuck at 25 N", {"peak_force": 25.0}
    )
    assert handle.result.error_code == ErrorCode.EXTRACTION_STUCK
    assert handle.result.error_message == "stuck at 25 N"
    assert handle.result.elapsed_time == 2.0


class Handled(Handle):
    """A goal that a server takes; `cancel`, if given, is called while it is checked."""

    def __init__(self, cancel=lambda handle: None):
        super().__init__()
        self.status, self.ended, self.cancel = GoalStatus.PENDING, Event(), cancel

    def get_goal_id(self):
        return GoalID(id="goal 1")

    def get_goal_status(self):
        return GoalStatus(status=self.status)

    def publish_feedback(self, feedback):
        pass

    def set_accepted(self):
        is_cancelled = self.status == GoalStatus.RECALLING
        self.status = GoalStatus.PREEMPTING if is_cancelled else GoalStatus.ACTIVE

    def _end(self, result, _text):
        self.result = result
        self.ended.set()

    set_aborted = set_canceled = set_succeeded = set_rejected = _end


class Host:
    """Keeps what a server would be served with."""

    def limits(self):
        return {}

    def serve(self, topic, action_type, on_goal, on_cancel):
        self.on_goal, self.on_cancel = on_goal, on_cancel


class DiscardCable(AbilityServer):
    """Waits for a cancel, unless it has something to return."""

    returned = None

    def check(self, goal):
        self.handle.cancel(self.handle)

    def elapsed(self):
        return lambda: 0.0

    def perform(self, running):
        if self.returned is None:
            running.is_cancelled_within(10.0)
            running.check()
        return self.returned


@pytest.fixture
def result_of(monkeypatch):
    """Return a function: handle, what the ability returns -> the result."""
    monkeypatch.setattr("rospy.get_time", lambda: 0.0)

    def result_of(handle, returned, host):
        server = DiscardCable(host=host)
        server.handle, server.returned = handle, returned
        host.on_goal(handle)
        assert handle.ended.wait(10.0)
        return handle.result

    return result_of


def test_a_cancel_that_comes_before_a_goal_is_accepted_is_not_lost(result_of):
    host = Host()

    def cancel(handle):
        handle.status = GoalStatus.RECALLING
        host.on_cancel(handle)

    assert result_of(Handled(cancel), None, host).error_code == ErrorCode.PREEMPTED


@pytest.mark.parametrize("returned", [Done("done", {"heigth": 1.0}), "done"])
def test_a_goal_whose_ability_returns_what_has_no_place_in_the_result_fails(result_of, returned):
    result = result_of(Handled(), returned, Host())
    assert result.error_code == ErrorCode.INTERNAL
    assert "AttributeError" in result.error_message


@pytest.mark.parametrize("numbers", [5, None, [1, "a", 2, 3], "abcd", [1, 2, 3], [1, 2, 3, inf]])
def test_what_is_no_pose_is_refused(numbers):
    with pytest.raises(ValueError, match="a pose is"):
        panel_pose(numbers)


@pytest.mark.parametrize("codes", [5, [1], {"InsertCable": 3}, {"InsertCable": []}])
def test_codes_of_fake_abilities_that_are_none_are_refused(codes):
    with pytest.raises(ValueError, match=r"codes are .*; allowed: numbers by abilities"):
        serve_all(codes, [])
