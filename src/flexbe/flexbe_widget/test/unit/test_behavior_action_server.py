"""What the action server does with goals, with an engine and clients of the test."""

from types import SimpleNamespace

import pytest
from flexbe_msgs.msg import BehaviorExecutionGoal, BehaviorSelection

from flexbe_core.engine.supervision import StatusCode
from flexbe_widget.ros import behavior_action_server
from flexbe_widget.ros.behavior_action_server import BehaviorActionServer, _Cancelled, _NewGoal
from flexbe_widget.ros.engine_link import Status


class Handle:
    """A goal of a client."""

    def __init__(self, name="A"):
        self._goal, self.end = BehaviorExecutionGoal(behavior_name=name), ""
        self.get_goal = lambda: self._goal

    def set_accepted(self):
        assert self.end == ""

    def _ends(self, how):
        assert self.end == ""
        self.end = how

    def set_canceled(self, result, text):
        self._ends("canceled")

    def set_rejected(self, result, text):
        self._ends(f"rejected: {text}")


class Link:
    """An engine that appears when the test says so."""

    def __init__(self):
        self.is_there, self.started, self.preempts = False, [], 0
        self.silent_s = lambda: 0.0

    def start(self, request):
        self.started.append(request)
        return 0

    def preempt(self):
        self.preempts += 1


@pytest.fixture
def server(monkeypatch):
    monkeypatch.setattr(
        behavior_action_server,
        "start_request",
        lambda library, name, *_: BehaviorSelection(behavior_checksum=ord(name)),
    )
    server = BehaviorActionServer.__new__(BehaviorActionServer)
    server._library, server._link = SimpleNamespace(), Link()
    server._run = server._next = server._given_up = None
    return server


def test_a_goal_that_is_replaced_before_its_request_is_never_run(server):
    first, second = Handle("A"), Handle("B")
    server._handle(_NewGoal(first))
    server._handle(_NewGoal(second))
    assert first.end == "canceled"
    server._link.is_there = True
    server._handle(None)
    assert [request.behavior_checksum for request in server._link.started] == [ord("B")]


def test_a_goal_that_is_cancelled_after_its_request_is_stopped_once_it_runs(server):
    handle, server._link.is_there = Handle(), True
    server._handle(_NewGoal(handle))
    server._handle(_Cancelled(handle))
    assert server._link.preempts == 0
    server._handle(Status(StatusCode.STARTED, ord("A"), (), 1))
    assert server._link.preempts == 1
    server._handle(Status(StatusCode.FINISHED, ord("A"), ("preempted",), 2))
    assert handle.end == "canceled"


def test_a_goal_with_a_key_that_has_no_value_is_rejected(server):
    handle = Handle()
    handle.get_goal().arg_keys = ["speed"]
    server._handle(_NewGoal(handle))
    assert handle.end == "rejected: the request has 0 values for 1 keys (speed); each key needs one"


def test_a_goal_whose_request_fails_in_any_way_is_rejected(server, monkeypatch):
    def fail(*_):
        raise RuntimeError("unexpected")

    monkeypatch.setattr(behavior_action_server, "start_request", fail)
    server._handle(_NewGoal(handle := Handle()))
    assert handle.end == "rejected: unexpected"
