"""The supervisor's line to the engine, without ROS: what becomes of a behavior that was lost."""

from types import SimpleNamespace

import pytest

from remodel_supervision.ros.peers import engine_link
from remodel_supervision.ros.peers.engine_link import EngineLink


class SentGoal:
    """A goal that ends on request."""

    def __init__(self):
        self.has_ended, self.cancelled = False, 0

    def wait(self, limit_s):
        return self.has_ended

    def cancel(self):
        self.cancelled += 1


@pytest.fixture
def goal(monkeypatch):
    """Return the goal that any behavior becomes; engine and action server answer at once."""
    goal = SentGoal()
    server = SimpleNamespace(
        send=lambda *_, **__: goal, is_there=True, wait=lambda limit_s: None, cancel_all=None
    )
    peer = SimpleNamespace(trouble="")
    monkeypatch.setattr(engine_link, "ActionServer", lambda *_: server)
    monkeypatch.setattr(engine_link, "Peer", lambda *_: peer)
    monkeypatch.setattr(engine_link.rospy, "Publisher", lambda *_, **__: None)
    monkeypatch.setattr(engine_link.rospy, "Subscriber", lambda *_, **__: None)
    return goal


@pytest.mark.parametrize(("has_ended", "cancelled"), [(False, 1), (True, 0)])
def test_a_lost_behavior_is_cancelled_before_the_engine_is_back(goal, has_ended, cancelled):
    at_wait = []
    loop = SimpleNamespace(
        every=lambda period_s, call: None,
        run_until=lambda holds, limit_s: at_wait.append(goal.cancelled),
    )
    link = EngineLink(loop)
    link._on_sign()
    link.wait(1.0)
    link.start("Place Wire W1")
    goal.has_ended = has_ended
    link.wait(1.0)
    assert at_wait == [0, cancelled]
