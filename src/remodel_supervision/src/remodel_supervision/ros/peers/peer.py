"""Another node, known by its connection, which the operating system closes when the node dies."""

from __future__ import annotations

from collections.abc import Callable

import rospy
from rospy import AnyMsg


class Peer:
    """A node that publishes a topic."""

    def __init__(
        self,
        title: str,
        topic: str,
        kind: type = AnyMsg,
        on_message: Callable[[object], None] | None = None,
    ) -> None:
        """Subscribe to its topic.

        Args:
            title: of the node, for errors.
            topic: that it alone publishes.
            kind: of the topic's messages.
            on_message: called with each message.
        """
        self._title = title
        self._subscriber = rospy.Subscriber(topic, kind, on_message or (lambda _: None))

    @property
    def is_there(self) -> bool:
        """Whether it is connected."""
        return self._subscriber.get_num_connections() > 0

    @property
    def trouble(self) -> str:
        """Why the node counts as gone; empty if it is connected."""
        if self.is_there:
            return ""
        return f"{self._title} is gone: nothing publishes {self._subscriber.resolved_name}"
