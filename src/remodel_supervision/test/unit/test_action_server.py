"""Every wait for an action server ends: with the goal's end, or with the loss of its server."""

import threading
from types import SimpleNamespace

import actionlib
import pytest
import rospy
from actionlib_msgs.msg import GoalStatus
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal

from remodel_production.errors import LostError
from remodel_supervision.ros import action_server
from remodel_supervision.ros.action_server import ActionServer


class FakeHandle:
    """A goal whose end a test decides."""

    def __init__(self, on_transition, on_feedback):
        self.on_transition, self.send_feedback = on_transition, on_feedback
        self.state, self.status, self.cancelled = actionlib.CommState.ACTIVE, None, False

    def end(self, status):
        self.state, self.status = actionlib.CommState.DONE, status
        self.on_transition(self)

    def cancel(self):
        self.cancelled = True

    def get_comm_state(self):
        return self.state

    def get_terminal_state(self):
        return self.status

    def get_goal_status_text(self):
        return "the text"

    def get_result(self):
        return "the result"


class FakeClient:
    """A client whose server is there or not."""

    def __init__(self, name, action):
        self.there, self.handle, self.sent = True, None, threading.Event()
        self.pub_goal = SimpleNamespace(impl=SimpleNamespace(check=lambda: None))  # none is dead

    def wait_for_server(self, timeout):
        assert not timeout.is_zero(), "to actionlib zero means forever"
        return self.there

    def send_goal(self, goal, on_transition, on_feedback):
        self.handle = FakeHandle(on_transition, on_feedback)
        self.sent.set()
        return self.handle


@pytest.fixture
def client(monkeypatch):
    made = []

    def make(name, action):
        made.append(FakeClient(name, action))
        return made[-1]

    monkeypatch.setattr(action_server.actionlib, "ActionClient", make)
    monkeypatch.setattr(action_server.rospy, "get_rostime", lambda: rospy.Time(1))
    monkeypatch.setattr(action_server.rospy, "is_shutdown", lambda: False)
    server = ActionServer("remodel/run_use_case", RunUseCaseAction, "the supervisor")
    return server, made[0]


def while_waiting(fake, action):
    """Do something in another thread once the goal is sent."""

    def do():
        assert fake.sent.wait(10.0)
        action(fake)

    threading.Thread(target=do, daemon=True).start()


def test_a_goal_that_ends_is_returned_with_its_feedback(client):
    server, fake = client
    heard = []

    def finish(fake):
        fake.handle.send_feedback(fake.handle, "half way")
        fake.handle.end(GoalStatus.SUCCEEDED)

    while_waiting(fake, finish)
    goal = server.ended(RunUseCaseGoal(), 10.0, heard.append)
    assert goal.succeeded
    assert not goal.lost
    assert (goal.result, goal.ending) == ("the result", "succeeded: the text")
    assert heard == ["half way"]


def test_a_server_that_goes_away_is_lost_and_its_goal_cancelled(client):
    server, fake = client
    while_waiting(fake, lambda fake: setattr(fake, "there", False))
    with pytest.raises(LostError, match="the supervisor has gone"):
        server.ended(RunUseCaseGoal(), 10.0)
    assert fake.handle.cancelled


def test_a_goal_that_takes_too_long_is_cancelled(client):
    server, fake = client
    with pytest.raises(LostError, match="took more than 0 s"):
        server.ended(RunUseCaseGoal(), 0.05)
    assert fake.handle.cancelled


def test_a_goal_that_the_server_has_forgotten_is_lost(client):
    server, fake = client
    while_waiting(fake, lambda fake: fake.handle.end(GoalStatus.LOST))
    with pytest.raises(LostError, match="the goal is forgotten"):
        server.ended(RunUseCaseGoal(), 10.0)


def test_a_server_that_never_comes_is_reported_with_what_to_start(client):
    server, fake = client
    fake.there = False
    with pytest.raises(LostError, match="run_use_case is not there after 0 s: start the super"):
        server.wait(0.05)


def test_no_server_is_there_before_there_is_a_time(client, monkeypatch):
    server, _ = client
    monkeypatch.setattr(action_server.rospy, "get_rostime", lambda: rospy.Time(0))
    assert not server.is_there
