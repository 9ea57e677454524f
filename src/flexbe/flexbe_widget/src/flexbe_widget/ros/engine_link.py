"""The connection to the behavior engine, and what actions of a behavior report meanwhile."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import rospy
from flexbe_msgs.msg import BehaviorLog, BehaviorSelection, BEStatus
from genpy import Message
from roslib.message import get_message_class
from std_msgs.msg import Empty, String

from flexbe_core.ros.master import hears, senders
from flexbe_widget.core.run_watch import SILENCE_S, Progress

# [s] Wall time by which the reason for a status may arrive after it.
_LOG_LIMIT_S = 0.5

# [s] Wall time after which a sender knows a connection that its receiver already has: rospy's
# sender adds it after its answer. The latched status arrives only then, but the first line of the
# log could be lost.
_CONNECTION_S = 0.01


@dataclass(frozen=True)
class Status:
    """A status of the engine.

    Attributes:
        number: counts statuses, to distinguish old ones: the first may be an old one.
    """

    code: int
    behavior_id: int
    args: tuple[str, ...]
    number: int


@dataclass(frozen=True)
class Entered:
    """Another state is active."""

    path: str


@dataclass(frozen=True)
class Logged:
    """The engine, or a state, logged a message."""

    severity: int
    text: str


@dataclass(frozen=True)
class Connected:
    """The engine has subscribed to requests."""


Event = Status | Entered | Logged | Connected


class _Listener(rospy.SubscribeListener):
    """Reports when the engine subscribes to requests."""

    def __init__(self, on_event: Callable[[Event], None]) -> None:
        self._on_event = on_event

    def peer_subscribe(self, topic_name: str, topic_publish: object, peer_publish: object) -> None:
        """Report it."""
        self._on_event(Connected())


class EngineLink:
    """The engine as its clients see it.

    Attributes:
        last_status: last status of the engine; None if there was none yet.
        last_error: last error that was logged since the last request.
    """

    def __init__(self, on_event: Callable[[Event], None]) -> None:
        """Call `on_event` with each event, from several threads."""
        self.last_status: Status | None = None
        self.last_error = ""
        self._on_event = on_event
        self._heard = time.monotonic()
        self._has_error = threading.Condition()
        self._heard_since: float | None = None
        self._start = rospy.Publisher(
            "flexbe/start_behavior",
            BehaviorSelection,
            subscriber_listener=_Listener(on_event),
            queue_size=100,
        )
        self._preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=100)
        self._subscribers = [
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
        """Return whether an engine has published a status, is connected both ways, and is alive.

        A process that is stopped keeps its connections, but is silent.
        """
        heard = set.intersection(*(senders(subscriber) for subscriber in self._subscribers))
        now = time.monotonic()
        if self.last_status is None or not heard:
            self._heard_since = None
            return False
        self._heard_since = self._heard_since or now
        hears_requests = any(hears(self._start, node) for node in heard)
        if self.silent_s() > SILENCE_S:
            return False
        return hears_requests and now - self._heard_since >= _CONNECTION_S

    @property
    def last_number(self) -> int:
        """Return the number of the last status; 0 if there was none."""
        return 0 if self.last_status is None else self.last_status.number

    def start(self, request: BehaviorSelection) -> int:
        """Request a behavior; statuses up to the returned number are older than the request."""
        self.last_error = ""
        older = self.last_number
        self._start.publish(request)
        return older

    def preempt(self) -> None:
        """Ask the engine to stop the running behavior."""
        self._preempt.publish()

    def silent_s(self) -> float:
        """Return the wall time [s] since the last message of the engine."""
        return time.monotonic() - self._heard

    def why(self) -> str:
        """Return the error that was logged since the last request; wait a moment for it.

        It is sent before the status that it explains, but on another connection.
        """
        with self._has_error:
            self._has_error.wait_for(lambda: self.last_error, _LOG_LIMIT_S)
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
            with self._has_error:
                self.last_error = message.text
                self._has_error.notify_all()
        self._on_event(Logged(message.status_code, message.text))


_SUFFIX = "ActionFeedback"
_FIELDS = ("message", "completed_percentage")


@dataclass(frozen=True)
class Progressed:
    """An action reported a progress that is worth a line."""

    text: str


class ActionFeedback:
    """Listens to the actions below its namespace whose feedback has `message` and percentage.

    These are the fields of all abilities in Deliverable 5.1; other actions are left alone.
    """

    def __init__(self, on_event: Callable[[object], None]) -> None:
        """Call `on_event` with each event, from several threads."""
        self._on_event = on_event

    def begin(self) -> None:
        """Subscribe to what is published now, in the background: this imports messages."""
        threading.Thread(target=self._find, daemon=True).start()

    def _find(self) -> None:
        try:
            published = rospy.get_published_topics(rospy.get_namespace())
        except (OSError, rospy.ROSException):
            return  # Without a master there is nothing to show, and others notice it.
        for topic, kind in published:
            if kind.endswith(_SUFFIX):
                self._subscribe(topic, kind)

    def _subscribe(self, topic: str, kind: str) -> None:
        try:
            message_class = get_message_class(kind)
        except Exception:  # noqa: BLE001 - whatever a package raises when it is imported
            return
        if message_class is None or any(
            not hasattr(message_class().feedback, field) for field in _FIELDS
        ):
            return
        progress = Progress(kind.partition("/")[2].removesuffix(_SUFFIX))

        def on_feedback(message: Message) -> None:
            feedback, goal = message.feedback, message.status.goal_id.id
            if text := progress.line(goal, feedback.message, feedback.completed_percentage):
                self._on_event(Progressed(text))

        rospy.Subscriber(topic, message_class, on_feedback, tcp_nodelay=True)
