"""The kit sends nothing before all that an engine publishes reaches it."""

from types import SimpleNamespace

import pytest
import rospy

from flexbe_testing.core.conformance import topics
from flexbe_testing.ros.conformance.wire import EngineWire

KIT, ENGINE = "/kit", "/engine"


class Engine:
    """The connections of an engine, as the bus info of its node lists them."""

    def __init__(self, sent, listed_as):
        self.connections = [
            (i, listed_as, "o", "TCPROS", f"/{topic}", True) for i, topic in enumerate(sent)
        ]

    def getBusInfo(self, _caller):  # noqa: N802 - XML-RPC's name
        return 1, "bus info", self.connections


@pytest.fixture
def kit(monkeypatch):
    """Return a kit that waits no time, and whose own list says that all is connected."""
    monkeypatch.setattr(rospy, "get_name", lambda: KIT)
    monkeypatch.setattr(rospy, "resolve_name", lambda topic: f"/{topic}")
    wire = object.__new__(EngineWire)
    wire.interrupt, wire._limit_s, wire._uri = (
        SimpleNamespace(check=lambda: None),
        0.0,
        "http://kit",
    )
    wire._engine_ends = {ENGINE}
    making = SimpleNamespace(get_stats_info=lambda: [(0, ENGINE, "i", "TCPROS", "", True)])
    wire._subscribers = {topic: SimpleNamespace(impl=making) for topic in topics.WATCHED}
    return wire


@pytest.mark.parametrize("listed_as", [KIT, "http://kit/"])
def test_what_the_engine_sends_here_is_connected(kit, listed_as):
    kit._engine_slave = Engine(topics.PUBLISHED, listed_as)
    assert kit.await_subscribed() == []


def test_a_connection_that_is_still_being_made_is_waited_for(kit):
    first, *others = topics.PUBLISHED
    kit._engine_slave = Engine(others, KIT)
    assert kit.await_subscribed() == [first]


def test_what_the_engine_sends_elsewhere_is_not_connected(kit):
    kit._engine_slave = Engine(topics.PUBLISHED, "/rosbag")
    assert kit.await_subscribed() == list(topics.PUBLISHED)
