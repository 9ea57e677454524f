"""The connection to an engine."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from genpy import Message
from roslib.message import get_message_class

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import ViolationError
from flexbe_testing.ros.conformance.interrupt import Interrupt
from flexbe_testing.ros.conformance.tape import Tape

# [s] Wall time between two inspections of a connection.
_POLL_S = 0.005


class NoEngineError(Exception):
    """There is no engine in this namespace that can be judged."""


class EngineWire:
    """All topics of an engine, in the namespace of this node.

    Attributes:
        tape: what the engine has published.
        interrupt: ends all waits when it is set.
    """

    def __init__(self, limit_s: float, interrupt: Interrupt) -> None:
        """Subscribe to everything that an engine publishes.

        Args:
            limit_s: how long to wait for an engine, and for each connection [s, wall time].
            interrupt: see the attributes.

        Raises:
            NoEngineError: if there is no engine in time.
        """
        self.interrupt = interrupt
        self.tape = Tape(interrupt)
        self._limit_s = limit_s
        self._master = rosgraph.Master(rospy.get_name())
        self._publishers: dict[str, rospy.Publisher] = {}
        self._subscribers = {topic: self._subscribe(topic) for topic in topics.WATCHED}
        if not self.until(lambda: bool(self._find_engine())):
            raise NoEngineError(
                f"no engine in namespace {rospy.get_namespace()!r} within {limit_s:g} s: nothing "
                f"publishes {rospy.resolve_name(topics.HEARTBEAT)} and subscribes to "
                f"{rospy.resolve_name(topics.START)}"
            )
        self.engine = self._find_engine()
        # Publishers know a connection by the node's name, subscribers by its address.
        uri = self._master.lookupNode(self.engine)
        self._engine_ends = {self.engine, uri}
        self._engine_slave = ServerProxy(uri)
        self._uri = str(self._master.lookupNode(rospy.get_name())).rstrip("/")

    def send(self, topic: str, message: Message) -> None:
        """Publish a message as soon as the engine is connected.

        Raises:
            ViolationError: if the engine does not subscribe to the topic.
        """
        publisher = self._publisher(topic, type(message))
        if not self.until(lambda: self._is_heard(publisher)):
            raise ViolationError(f"the engine does not subscribe to {topic}")
        publisher.publish(message)

    def send_if_heard(self, topic: str, message: Message, within_s: float) -> None:
        """Publish a message; the engine need not be connected.

        Args:
            topic: where to.
            message: what.
            within_s: how long it may take to connect [s, wall time].
        """
        publisher = self._publisher(topic, type(message))
        self.until(lambda: self._is_heard(publisher), within_s)
        publisher.publish(message)

    def subscribe_again(self, topic: str) -> None:
        """Subscribe as one who joins now: with what is latched, and nothing before."""
        self._subscribers[topic].unregister()
        self._subscribers[topic] = self._subscribe(topic)

    def await_subscribed(self) -> list[str]:
        """Wait until all that an engine publishes is connected; return the topics that are not."""
        missing: list[str] = []

        def is_complete() -> bool:
            sent = self._sent_here()
            missing[:] = [
                topic for topic in topics.PUBLISHED if rospy.resolve_name(topic) not in sent
            ]
            return not missing

        self.until(is_complete)
        return missing

    def publishers(self, topic: str) -> list[str]:
        """Return the other nodes that publish a topic of this node's namespace."""
        publish, _, _ = self._master.getSystemState()
        found = dict(publish).get(rospy.resolve_name(topic), [])
        return [node for node in found if node != rospy.get_name()]

    def is_subscribed(self, topic: str) -> bool:
        """Return whether any node subscribes to a topic of this node's namespace."""
        _, subscribe, _ = self._master.getSystemState()
        return rospy.resolve_name(topic) in dict(subscribe)

    def topic_types(self) -> dict[str, str]:
        """Return the types of all topics that the master knows."""
        return dict(self._master.getTopicTypes())

    def _subscribe(self, topic: str) -> rospy.Subscriber:
        kind = get_message_class(topics.WATCHED[topic])
        on_message = functools.partial(self.tape.add, topic=topic)
        return rospy.Subscriber(topic, kind, on_message, tcp_nodelay=True)

    def _publisher(self, topic: str, kind: type) -> rospy.Publisher:
        if topic not in self._publishers:
            self._publishers[topic] = rospy.Publisher(topic, kind, queue_size=10, tcp_nodelay=True)
        return self._publishers[topic]

    def _find_engine(self) -> str:
        publish, subscribe, _ = self._master.getSystemState()
        beating = dict(publish).get(rospy.resolve_name(topics.HEARTBEAT), [])
        starting = dict(subscribe).get(rospy.resolve_name(topics.START), [])
        return next((node for node in beating if node in starting), "")

    def _sent_here(self) -> set[str]:
        """Return the topics that the engine sends to this node.

        By the engine's end: a subscriber lists a connection while it is still being made, and what
        is published until then is lost.
        """
        _, _, connections = self._engine_slave.getBusInfo(rospy.get_name())
        return {
            entry[4]
            for entry in connections
            if entry[1].rstrip("/") in (rospy.get_name(), self._uri) and entry[2] == "o"
        }

    def _is_heard(self, publisher: rospy.Publisher) -> bool:
        """Return whether the engine is connected, by both ends.

        An engine that subscribes again for each behavior leaves a dead connection here for a while.
        """
        if not any(entry[1] in self._engine_ends for entry in publisher.impl.get_stats_info()):
            return False
        _, _, connections = self._engine_slave.getBusInfo(rospy.get_name())
        return any(
            entry[1].rstrip("/") == self._uri and entry[2] == "i" and entry[4] == publisher.name
            for entry in connections
        )

    def until(self, condition: Callable[[], bool], limit_s: float | None = None) -> bool:
        """Poll a condition about connections, of which rospy has no notification."""
        end = time.monotonic() + (self._limit_s if limit_s is None else limit_s)
        while not condition():
            self.interrupt.check()
            if time.monotonic() > end or rospy.is_shutdown():
                return False
            time.sleep(_POLL_S)
        return True
