"""What the actions of a behavior report while they work."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

import rospy
from genpy import Message
from roslib.message import get_message_class

from flexbe_widget.core.progress import Progress

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
