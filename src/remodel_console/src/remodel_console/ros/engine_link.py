"""The engine as the console sees it: its messages become events, orders become messages."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial

import rospy
from flexbe_msgs.msg import (
    BehaviorLog,
    BehaviorSelection,
    BEStatus,
    CommandFeedback,
    ContainerStructure,
    OutcomeRequest,
)
from flexbe_msgs.srv import GetUserdata
from genpy import Message
from std_msgs.msg import Bool, Empty, Int32, String, UInt8

from flexbe_core.ros.master import is_heard
from flexbe_core.ros.topics import START_AT
from remodel_console.core import running
from remodel_console.core.run_view import (
    Acknowledged,
    Asked,
    EngineSeen,
    EngineStatus,
    Entered,
    Event,
    Left,
    LevelSeen,
)
from remodel_console.core.running import Level, LogLine, Structure
from remodel_console.errors import CommandError
from remodel_console.ros import topics

_POLL_S = 0.2  # between two checks whether the engine is running
_READ_EVERY_S = 1.0  # between two checks of the breakpoints, a parameter
_CHECK_EVERY_S = 0.01  # while the engine connects
_CONNECT_S = 5.0  # in which an engine that is there subscribes to each of its topics
_USERDATA_S = 2.0  # in which the engine answers what its userdata is

_PUBLISHED = {
    topics.START: BehaviorSelection,
    topics.ATTACH: UInt8,
    topics.AUTONOMY: UInt8,
    topics.TRANSITION: OutcomeRequest,
    topics.LOCK: String,
    topics.UNLOCK: String,
    topics.PAUSE: Bool,
    topics.REPEAT: Empty,
    topics.PREEMPT: Empty,
    topics.SHOW_STRUCTURE: Int32,
}


class EngineLink:
    """Subscribes to the engine of this namespace, and publishes orders to it."""

    def __init__(
        self,
        report: Callable[[Event], None],
        report_line: Callable[[LogLine], None],
        report_breakpoints: Callable[[frozenset[str]], None] = lambda paths: None,
    ) -> None:
        """Connect; what is reported to is called on threads of their own."""
        self._report = report
        self._report_breakpoints = report_breakpoints
        self._read_s = 0.0
        self._was_there = False
        self._stop = threading.Event()
        rospy.on_shutdown(self._stop.set)
        self._publishers = {
            topic: rospy.Publisher(topic, kind, queue_size=10) for topic, kind in _PUBLISHED.items()
        }
        subscribe = partial(rospy.Subscriber, tcp_nodelay=True)
        self._heartbeat = subscribe(topics.HEARTBEAT, Empty)
        self._updates = subscribe(topics.UPDATE, String, lambda m: report(Entered(m.data)))
        subscribe(topics.AUTONOMY_IN_FORCE, UInt8, lambda m: report(LevelSeen(m.data)))
        subscribe(topics.LEFT, String, lambda m: report(_left(m)))
        subscribe(topics.STATUS, BEStatus, self._take_status)
        subscribe(topics.REQUEST, OutcomeRequest, lambda m: report(Asked(m.target, m.outcome)))
        subscribe(topics.STRUCTURE, ContainerStructure, lambda m: report(_structure(m)))
        subscribe(topics.FEEDBACK, CommandFeedback, self._take_feedback)
        subscribe(
            topics.LOG,
            BehaviorLog,
            lambda m: report_line(LogLine(time.time(), m.status_code, m.text)),
        )
        threading.Thread(target=self._watch, name="engine", daemon=True).start()

    @property
    def is_followed(self) -> bool:
        """Return whether a mirror publishes the active state, besides the engine."""
        return self._updates.get_num_connections() > (1 if self._was_there else 0)

    def send(self, order: running.Order) -> None:
        """Send an order, once the engine has subscribed to its topic.

        Raises:
            CommandError: if no engine is there to take it.
        """
        if not self._was_there:
            raise CommandError(
                "no behavior engine is running; start one: "
                "roslaunch flexbe_onboard behavior_onboard.launch"
            )
        for topic, message in _messages(order):
            self._expect_subscriber(topic)
            self._publishers[topic].publish(message)

    def _expect_subscriber(self, topic: str) -> None:
        """Wait for the engine, which connects to each topic of its own accord."""
        end_s = time.monotonic() + _CONNECT_S
        while not is_heard(self._publishers[topic]):
            if time.monotonic() > end_s or self._stop.wait(_CHECK_EVERY_S):
                raise CommandError(
                    f"the engine does not subscribe to {topic}; does a behavior run?"
                )

    def userdata(self) -> tuple[tuple[str, str, str, str], ...]:
        """Return (where, key, type, value) of the userdata of what runs.

        Raises:
            CommandError: if the engine does not answer.
        """
        try:
            rospy.wait_for_service(topics.USERDATA, timeout=_USERDATA_S)
            answer = rospy.ServiceProxy(topics.USERDATA, GetUserdata)("")
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise CommandError(f"the engine does not return its userdata: {error}") from error
        return tuple((d.state, d.key, d.type, d.data) for d in answer.userdata)

    def set_breakpoints(self, paths: frozenset[str]) -> None:
        """Have the engine ask before it leaves these states.

        Raises:
            CommandError: if the master does not answer.
        """
        try:
            rospy.set_param(topics.BREAKPOINTS, sorted(paths))
        except (OSError, rospy.ROSException) as error:
            raise CommandError(f"the breakpoints cannot be set: {error}") from error

    def _read_breakpoints(self) -> None:
        """Read what other clients may have set; `rosrun flexbe_widget breakpoint` does."""
        self._read_s = time.monotonic()
        try:
            paths = rospy.get_param(topics.BREAKPOINTS, [])
        except (OSError, rospy.ROSException):
            return
        known = paths if isinstance(paths, list) else []
        self._report_breakpoints(frozenset(map(str, known)))

    def _watch(self) -> None:
        while not self._stop.wait(_POLL_S):
            if time.monotonic() - self._read_s > _READ_EVERY_S:
                self._read_breakpoints()
            # One that has just come may be heard before it hears what it is sent.
            hears = is_heard(self._publishers[topics.START])
            is_there = hears and self._heartbeat.get_num_connections() > 0
            if is_there != self._was_there:
                self._was_there = is_there
                self._report(EngineSeen(is_there))

    def _take_status(self, message: BEStatus) -> None:
        self._report(EngineStatus(message.code, message.behavior_id, tuple(message.args)))

    def _take_feedback(self, message: CommandFeedback) -> None:
        self._report(Acknowledged(message.command, tuple(message.args)))


def _messages(order: running.Order) -> tuple[tuple[str, Message], ...]:
    """Return the topics and messages that an order becomes."""
    match order:
        case running.Start():
            return ((topics.START, _selection(order)),)
        case running.Switch(_, behavior_id, checksum, level):
            version = BehaviorSelection(
                behavior_id=behavior_id, behavior_checksum=checksum, autonomy_level=level
            )
            return ((topics.START, version),)
        case running.Attach(level):
            return ((topics.ATTACH, UInt8(level)),)
        case running.SetAutonomy(level):
            return ((topics.AUTONOMY, UInt8(level)),)
        case running.TakeOutcome(path, index):
            target = path if order.is_by_path else path.rpartition("/")[2]
            return ((topics.TRANSITION, OutcomeRequest(index, target)),)
        case running.Hold(path):
            return ((topics.LOCK, String(path)),)
        case running.Release(path):
            return ((topics.UNLOCK, String(path)),)
        case running.SimpleOrder.PAUSE | running.SimpleOrder.RESUME:
            return ((topics.PAUSE, Bool(order is running.SimpleOrder.PAUSE)),)
        case running.SimpleOrder.REPEAT:
            return ((topics.REPEAT, Empty()),)
        case running.SimpleOrder.SHOW_STRUCTURE:
            return ((topics.SHOW_STRUCTURE, Int32(0)),)
        case running.SimpleOrder.PREEMPT:
            return ((topics.PREEMPT, Empty()),)


def _selection(order: running.Start) -> BehaviorSelection:
    start = ((START_AT, order.start_at),) if order.start_at else ()
    parameters = (*order.parameters, *start)
    return BehaviorSelection(
        behavior_id=order.behavior_id,
        behavior_checksum=order.source_checksum,
        autonomy_level=order.level,
        arg_keys=[key for key, _ in parameters],
        arg_values=[value for _, value in parameters],
        input_keys=[key for key, _ in order.inputs],
        input_values=[value for _, value in order.inputs],
    )


def _left(message: String) -> Left:
    path, _, outcome = message.data.partition(" > ")
    return Left(path, outcome)


def _structure(message: ContainerStructure) -> Structure:
    levels = (
        Level(c.path, tuple(c.children), tuple(c.outcomes), tuple(c.transitions))
        for c in message.containers
    )
    return Structure(message.behavior_id, tuple(levels))
