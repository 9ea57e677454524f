"""The line to the behavior engine: requests out, statuses and news in."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import rospy
from flexbe_msgs.msg import BehaviorLog, BehaviorSelection, BEStatus
from std_msgs.msg import Empty, String

from flexbe_widget.core.run_watch import SILENCE_S

# [s] Wall time by which the reason for a status may come behind it.
_LOG_LIMIT_S = 0.5


# [s] Wall time by which a sender knows a connection that its receiver has already: rospy's sender
# adds it after it has answered. The latched status comes only when that is over; of the log a first
# line could be lost.
_SETTLING_S = 0.01


@dataclass(frozen=True)
class Status:
    """The engine says what it is doing.

    Attributes:
        number: counts statuses, so that old ones are known as such: the first may be an old one.
    """

    code: int
    behavior_id: int
    args: tuple[str, ...]
    number: int


@dataclass(frozen=True)
class Entered:
    """The behavior is at another state."""

    path: str


@dataclass(frozen=True)
class Logged:
    """The engine, or a state, tells something."""

    severity: int
    text: str


@dataclass(frozen=True)
class Connected:
    """The engine hears requests."""


Event = Status | Entered | Logged | Connected


class _Listener(rospy.SubscribeListener):
    """Tells when the engine subscribes to requests."""

    def __init__(self, on_event: Callable[[Event], None]) -> None:
        self._on_event = on_event

    def peer_subscribe(self, topic_name: str, topic_publish: object, peer_publish: object) -> None:
        """Tell it."""
        self._on_event(Connected())


class EngineLink:
    """The engine as its clients see it.

    Attributes:
        last_status: what the engine said last; None if it has said nothing yet.
        last_error: the last error that was told since the last request.
    """

    def __init__(self, on_event: Callable[[Event], None]) -> None:
        """Call `on_event` with whatever the engine says, from several threads."""
        self.last_status: Status | None = None
        self.last_error = ""
        self._on_event = on_event
        self._heard = time.monotonic()
        self._told = threading.Condition()
        self._heard_since: float | None = None
        self._start = rospy.Publisher(
            "flexbe/start_behavior",
            BehaviorSelection,
            subscriber_listener=_Listener(on_event),
            queue_size=100,
        )
        self._preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=100)
        self._news = [
            rospy.Subscriber(f"flexbe/{topic}", message_type, callback, tcp_nodelay=True)
            for topic, message_type, callback in (
                ("status", BEStatus, self._on_status),
                ("log", BehaviorLog, self._on_log),
            )
        ]
        rospy.Subscriber("flexbe/heartbeat", Empty, self._on_heartbeat)
        rospy.Subscriber("flexbe/behavior_update", String, self._on_update, tcp_nodelay=True)

    @property
    def is_there(self) -> bool:
        """Return whether an engine has reported what it does, hears requests, and is heard.

        A process that is stopped keeps its connections, but is silent.
        """
        heard = set.intersection(*(_senders(subscriber) for subscriber in self._news))
        now = time.monotonic()
        if self.last_status is None or not heard:
            self._heard_since = None
            return False
        self._heard_since = self._heard_since or now
        hears_requests = any(self._start.impl.has_connection(node) for node in heard)
        if self.silent_s() > SILENCE_S:
            return False
        return hears_requests and now - self._heard_since >= _SETTLING_S

    @property
    def last_number(self) -> int:
        """Return the number of the last status; 0 if there was none."""
        return 0 if self.last_status is None else self.last_status.number

    def start(self, request: BehaviorSelection) -> int:
        """Ask for a behavior; statuses with the number that is returned, or less, are older."""
        self.last_error = ""
        older = self.last_number
        self._start.publish(request)
        return older

    def preempt(self) -> None:
        """Ask to stop what runs."""
        self._preempt.publish()

    def silent_s(self) -> float:
        """Return how long [s] of wall time nothing has been heard."""
        return time.monotonic() - self._heard

    def why(self, limit_s: float = _LOG_LIMIT_S) -> str:
        """Return the error that was told since the last request, waiting for it for a while [s].

        It is told before the status that it explains, but on another connection.
        """
        with self._told:
            self._told.wait_for(lambda: self.last_error, limit_s)
        return self.last_error

    def _on_status(self, message: BEStatus) -> None:
        self._heard = time.monotonic()
        number = self.last_number + 1
        self.last_status = Status(message.code, message.behavior_id, tuple(message.args), number)
        self._on_event(self.last_status)

    def _on_heartbeat(self, message: Empty) -> None:
        self._heard = time.monotonic()

    def _on_update(self, message: String) -> None:
        self._on_event(Entered(message.data))

    def _on_log(self, message: BehaviorLog) -> None:
        if message.status_code == BehaviorLog.ERROR:
            with self._told:
                self.last_error = message.text
                self._told.notify_all()
        self._on_event(Logged(message.status_code, message.text))


def _senders(subscriber: rospy.Subscriber) -> set[str]:
    """Return the names of the nodes from which the subscriber receives; "unknown" is none yet."""
    return {c.callerid_pub for c in subscriber.impl.connections} - {"unknown"}
