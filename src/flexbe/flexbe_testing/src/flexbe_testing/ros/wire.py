"""The connection to an engine: what it publishes is recorded, and waits can be interrupted."""

from __future__ import annotations

import contextlib
import functools
import signal
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from typing import Any
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from genpy import Message
from roslib.message import get_message_class

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import ViolationError

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

        An engine that subscribes again for each behavior leaves a dead connection here until it is
        dropped, and lists the new one while that is still being made: what is sent then is lost.
        """
        publisher.impl.check()
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


# Remember what an engine publishes until a scenario asks for it


# Codes of BEStatus.
_STARTED, _SWITCHING, _ERROR = 0, 6, 11

# What the states of the conformance behaviors log: event and path, or values.
EVENT = "events of the states"
_EVENT_PREFIX = "conformance: "

# A message of ROS, or the text of an event.
Recorded = Any


class Tape:
    """Messages in the order of their arrival, for each topic; may be added from any thread."""

    def __init__(self, interrupt: Interrupt) -> None:
        """Begin empty; waits end when `interrupt` is set."""
        self._interrupt = interrupt
        self._arrived = threading.Condition()
        self._waiting: dict[str, deque[Recorded]] = defaultdict(deque)
        self.statuses: list[Recorded] = []
        self.beats: list[float] = []

    def add(self, message: Recorded, topic: str) -> None:
        """Take a message."""
        with self._arrived:
            if topic == topics.HEARTBEAT:
                self.beats.append(time.monotonic())
            elif topic == topics.LOG and message.text.startswith(_EVENT_PREFIX):
                self._waiting[EVENT].append(message.text.removeprefix(_EVENT_PREFIX))
            else:
                self._waiting[topic].append(message)
            if topic == topics.STATUS:
                self.statuses.append(message)
            self._arrived.notify_all()

    def next(self, topic: str, limit_s: float) -> Recorded | None:
        """Return the next message of a topic; None if none arrives in time."""
        return self.find(topic, lambda message: True, limit_s)

    def find(
        self, topic: str, matches: Callable[[Recorded], bool], limit_s: float
    ) -> Recorded | None:
        """Return the next message that matches and drop those before it; None if none arrives."""
        end = time.monotonic() + limit_s
        with self._arrived:
            waiting = self._waiting[topic]
            while self._interrupt.wait_for(
                self._arrived, lambda: waiting, max(0.0, end - time.monotonic())
            ):
                message = waiting.popleft()
                if matches(message):
                    return message
        return None

    def wait(self, condition: Callable[[], bool], limit_s: float) -> bool:
        """Wait until a condition on the tape holds; return whether it does."""
        with self._arrived:
            return self._interrupt.wait_for(self._arrived, condition, limit_s)

    def left(self, topic: str) -> list[Recorded]:
        """Return the messages that have not been taken."""
        with self._arrived:
            return list(self._waiting[topic])

    def clear(self) -> None:
        """Drop all messages."""
        with self._arrived:
            self._waiting.clear()

    @property
    def is_running(self) -> bool:
        """Whether a behavior runs, by the statuses so far."""
        return self._last_code() == _STARTED

    @property
    def is_switching(self) -> bool:
        """Whether one behavior was replaced and the next has not started, by the statuses."""
        return self._last_code() == _SWITCHING

    def _last_code(self) -> int | None:
        """Return the last status code; ERROR refuses a request, and leaves the run as it is."""
        codes = (message.code for message in reversed(self.statuses))
        return next((code for code in codes if code != _ERROR), None)


# Ctrl-C while an engine is judged: a flag that all waits check.
#
# An exception in the middle of a call, such as a request to the engine's node, would leave its
# connection unusable for the calls that stop the behavior.


# [s] Wall time after which a wait checks the flag.
_CHECK_S = 0.05


class InterruptedByUserError(Exception):
    """The user has pressed Ctrl-C."""


class Interrupt:
    """Whether the user has pressed Ctrl-C.

    Attributes:
        is_set: the user has.
    """

    def __init__(self) -> None:
        self.is_set = False
        self._is_held = False

    def check(self) -> None:
        """Raise if the user has pressed Ctrl-C.

        Raises:
            InterruptedByUserError: if so, unless it is held back.
        """
        if self.is_set and not self._is_held:
            raise InterruptedByUserError

    def wait_for(
        self, arrived: threading.Condition, condition: Callable[[], object], limit_s: float
    ) -> bool:
        """Wait for a condition as `arrived` does, whose lock is held; return whether it holds.

        Args:
            arrived: is notified when the condition may have changed.
            condition: what is waited for.
            limit_s: no longer than this [s, wall time].

        Raises:
            InterruptedByUserError: as soon as the user has pressed Ctrl-C.
        """
        end = time.monotonic() + limit_s
        while True:
            self.check()
            left = end - time.monotonic()
            if arrived.wait_for(condition, max(0.0, min(left, _CHECK_S))):
                return True
            if left <= _CHECK_S:
                return False

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Hold Ctrl-C back: the waits within go on, and a later check raises."""
        self._is_held = True
        try:
            yield
        finally:
            self._is_held = False

    @contextlib.contextmanager
    def on_sigint(self) -> Iterator[None]:
        """Set the flag at SIGINT, in place of an exception wherever the main thread is."""
        before = signal.signal(signal.SIGINT, self._on_sigint)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    def _on_sigint(self, *_: object) -> None:
        self.is_set = True
