"""Publish what states find in the userdata and leave behind, as long as a node subscribes.

The thread of the run only keeps references (`take`); another one prints and publishes, a moment
later, so that the run has sent its next goal before.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from io import BytesIO

import rospy
from genpy import Message
from std_msgs.msg import String

from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.supervision.commands import ShowValues
from flexbe_core.engine.userdata.fingerprint import Value
from flexbe_core.engine.userdata.visit import Printer, Visit, visit_of
from flexbe_core.ros import clock, topics
from flexbe_core.ros.command_hub import HUB

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
                text = self._printer.text_of(self._visits.popleft()).as_json()
                if not rospy.is_shutdown():
                    publisher.publish(String(text))


def printed(value: Value) -> str:
    """Return the text of a value."""
    if isinstance(value, Message):
        buffer = BytesIO()
        value.serialize(buffer)
        if buffer.tell() > LONGEST:
            return f"<{buffer.tell()} bytes>"
    if isinstance(value, str | bytes) and len(value) > LONGEST:
        return f"{value[:LONGEST]!s}…"
    text = str(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


# The publisher belongs to the process, as all proxies' do.
VISITS = VisitPublisher()
