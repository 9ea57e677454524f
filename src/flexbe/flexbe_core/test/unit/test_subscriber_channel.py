"""What arrives on a topic reaches all who listen to it."""

import pytest
import rospy

from flexbe_core import EventState
from flexbe_core.proxy.proxy_subscriber_cached import _Channel


@pytest.fixture
def reports(monkeypatch):
    found = []
    monkeypatch.setattr(rospy, "logerr", lambda text, *words: found.append(text % words))
    return found


def test_a_callback_that_fails_keeps_no_other_from_the_message(reports):
    channel, received = _Channel(buffered=False), []
    channel.add_callback(lambda message: 1 / 0)
    channel.add_callback(received.append)
    channel.arrived("message")
    assert received == [channel.last] == ["message"]
    assert "ZeroDivisionError" in reports[0]


def test_a_state_that_is_gone_is_forgotten_also_while_messages_arrive(reports):
    class Listening(EventState):
        def take(self, message):
            """Listen."""

    channel, received, state = _Channel(buffered=False), [], Listening(outcomes=["done"])
    state.execute = None  # the instance refers to itself, and would be gone only later

    def take(message):
        nonlocal state
        state = None
        if not received:
            received.append(message)
            channel.arrived("another, on the thread of another connection")

    channel.add_callback(take)
    channel.add_callback(state.take)
    channel.add_callback(received.append)
    channel.arrived("message")
    assert received == ["message", "another, on the thread of another connection", "message"]
    assert reports == []
    assert len(channel._callbacks) == 2
