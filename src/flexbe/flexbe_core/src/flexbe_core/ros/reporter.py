"""Publish what happens in a run."""

from __future__ import annotations

import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Sequence
from io import BytesIO

import rospy
from flexbe_msgs.msg import (
    BehaviorSync,
    CommandFeedback,
    Container,
    ContainerStructure,
    OutcomeRequest,
)
from genpy import Message
from std_msgs.msg import String, UInt8

from flexbe_core.core.state import State
from flexbe_core.engine.definitions import definition_at, structure_of
from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.supervision import (
    NO_OUTCOME,
    Answered,
    Ended,
    Entered,
    Event,
    Forced,
    Left,
    Raised,
    Refused,
    Requested,
    Shown,
    ShowValues,
    Synced,
    checksum,
)
from flexbe_core.engine.user_data import Value
from flexbe_core.engine.visit import Printer, Visit, visit_of
from flexbe_core.logger import Logger
from flexbe_core.proxy.proxy_publisher import ProxyPublisher
from flexbe_core.ros import clock, topics
from flexbe_core.ros.command_hub import HUB
from flexbe_core.state_logger import StateLogger

# [s] Wall time for which the same error of a held state is not logged again.
_SAME_ERROR_S = 10.0


def advertise() -> None:
    """Advertise what runs publish."""
    ProxyPublisher(topics.PUBLISHED)
    ProxyPublisher({topics.ACTIVE_STATE: String, topics.AUTONOMY_IN_FORCE: UInt8}, _latch=True)


class Reporter:
    """Turns events into messages and log lines."""

    def __init__(self, root: State) -> None:
        """Report about the run of `root`."""
        self._root = root
        self._publisher = ProxyPublisher()
        self._logged: dict[str, tuple[str, float]] = {}

    def report(self, events: Sequence[Event]) -> None:
        """Publish events in their order."""
        for event in events:
            self._publish(event)

    def structure(self) -> None:
        """Publish the structure of the run's root."""
        containers = [
            Container(
                path=part.path,
                children=list(part.children),
                outcomes=list(part.outcomes),
                transitions=list(part.transitions),
                autonomy=list(part.autonomy),
            )
            for part in structure_of(self._root)
        ]
        self._send(
            topics.MIRROR_STRUCTURE,
            ContainerStructure(behavior_id=self._behavior_id(), containers=containers),
        )

    def autonomy(self, level: int) -> None:
        """Publish the autonomy level that is in force."""
        self._send(topics.AUTONOMY_IN_FORCE, UInt8(level))

    def _publish(self, event: Event) -> None:
        match event:
            case Entered():
                # A supervised behavior is followed by a mirror, which publishes this itself. What
                # is executed by hand has no id, and is not a behavior.
                if not self._root._is_controlled and getattr(self._root, "id", None) is not None:
                    self._send(topics.BEHAVIOR_UPDATE, String(event.path))
            case Left():
                self._send(topics.MIRROR_OUTCOME, UInt8(event.index))
                self._send(topics.CURRENT_STATE, String(f"{event.path} > {event.outcome}"))
            case Requested():
                self._send(topics.OUTCOME_REQUEST, OutcomeRequest(event.index, event.path))
                if StateLogger.enabled and event.index != NO_OUTCOME:
                    self._log_request(event)
            case Forced():
                about = {"type": "forced", "forced": event.outcome, "requested": event.requested}
                StateLogger.log("flexbe.operator", definition_at(self._root, event.path), **about)
            case Ended():
                state = definition_at(self._root, event.path)
                StateLogger.log("flexbe.outcomes", state, outcome=event.outcome)
            case Answered():
                feedback = CommandFeedback(event.command, list(event.args))
                self._send(topics.COMMAND_FEEDBACK, feedback)
            case Synced():
                sync = BehaviorSync(self._behavior_id(), checksum(event.path))
                self._send(topics.MIRROR_SYNC, sync)
            case Shown():
                self._send(topics.ACTIVE_STATE, String(event.path))
            case Refused():
                Logger.logwarn("%s", event.text)
            case Raised():
                self._log_error(event)

    def _log_error(self, event: Raised) -> None:
        error = event.error
        text = f"{type(error).__name__}: {error}"
        last, at = self._logged.get(event.path, ("", 0.0))
        if text == last and time.monotonic() - at < _SAME_ERROR_S:
            return
        self._logged[event.path] = (text, time.monotonic())
        trace = "".join(traceback.format_exception(error))
        then = "; it stays active and is tried again" if event.held else ""
        Logger.logerr("%s: %s%s", event.path or "root", text, then)
        Logger.local(trace, Logger.REPORT_ERROR)

    def _log_request(self, event: Requested) -> None:
        state: State = definition_at(self._root, event.path)
        outcome = state.outcomes[event.index]
        levels = getattr(state.parent, "_autonomy", {}).get(state.name, {})
        about = {
            "type": "request",
            "request": outcome,
            "autonomy": getattr(self._root, "autonomy_level", None),
            "required": levels.get(outcome, -1),
        }
        StateLogger.log("flexbe.operator", state, **about)

    def _behavior_id(self) -> int:
        return getattr(self._root, "id", None) or 0

    def _send(self, topic: str, message: Message) -> None:
        if not self._publisher.is_available(topic):
            advertise()
        self._publisher.publish(topic, message)


# Publish what states find in the userdata and leave behind, as long as a node subscribes.
#
# The thread of the run only keeps references (`take`); another one prints and publishes, a moment
# later, so that the run has sent its next goal before.


# [s] Wall time by which messages follow the visits: longer than what a run needs for a goal.
_BEHIND_S = 0.005

# Of more visits in that time only the last are published: no operator can follow the others.
_MOST_VISITS = 200

# Characters of a printed value beyond which it is cut off, and bytes of a message beyond which it
# is not printed: an image would delay the run.
LONGEST = 20_000


class VisitPublisher(rospy.SubscribeListener):
    """Publishes the visits of the states of this process."""

    def __init__(self) -> None:
        """Prepare; nothing is advertised yet."""
        super().__init__()
        self._publisher: rospy.Publisher | None = None
        self._visits: deque[Visit] = deque(maxlen=_MOST_VISITS)
        self._has_visits = threading.Event()
        self._printer = Printer(printed)

    def advertise(self) -> None:
        """Advertise the topic, once."""
        if self._publisher is None:
            self._publisher = rospy.Publisher(
                topics.VISITS, String, subscriber_listener=self, queue_size=1000
            )
            threading.Thread(target=self._publish, name="visits", daemon=True).start()

    def observer(self) -> Callable[[Leaf, bool], None] | None:
        """Return what takes in the visits of states; None without a subscriber."""
        publisher = self._publisher
        return self._take if publisher and publisher.get_num_connections() > 0 else None

    def peer_subscribe(
        self,
        topic_name: str,
        topic_publish: Callable[..., None],
        peer_publish: Callable[..., None],
    ) -> None:
        """Send a new subscriber all values, at the active state."""
        self._printer.is_complete = True
        HUB.post(ShowValues())

    def _take(self, leaf: Leaf, has_left: bool) -> None:
        """Keep what is around a state that was entered or left."""
        self._visits.append(visit_of(leaf, clock.now(), has_left))
        self._has_visits.set()

    def _publish(self) -> None:
        publisher = self._publisher
        while publisher is not None and not rospy.is_shutdown():
            self._has_visits.wait()
            time.sleep(_BEHIND_S)
            self._has_visits.clear()
            while self._visits:
                self._publish_visit(publisher, self._visits.popleft())

    def _publish_visit(self, publisher: rospy.Publisher, visit: Visit) -> None:
        try:
            text = self._printer.text_of(visit).as_json()
        except Exception as error:  # noqa: BLE001 - a state may change the value meanwhile
            self._printer.is_complete = True
            rospy.logdebug("a visit of %s is not published: %s", visit.path, error)
            return
        if not rospy.is_shutdown():
            publisher.publish(String(text))


def printed(value: Value) -> str:
    """Return the text of a value."""
    try:
        if isinstance(value, Message):
            buffer = BytesIO()
            value.serialize(buffer)
            if buffer.tell() > LONGEST:
                return f"<{buffer.tell()} bytes>"
        if isinstance(value, str | bytes) and len(value) > LONGEST:
            return f"{value[:LONGEST]!s}…"
        text = str(value)
    except Exception as error:  # noqa: BLE001 - whatever users put into userdata
        text = f"<{type(value).__name__} that cannot be printed: {error!r}>"
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


# The publisher belongs to the process, as all proxies' do.
VISITS = VisitPublisher()
