"""Another node, known to be there by its connection: the operating system tells of its death."""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy
from rospy import AnyMsg

from remodel_planner.errors import LostError

_LOOK_S = 0.02


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

    def require(self) -> None:
        """Return if it is connected.

        Raises:
            LostError: if it is not.
        """
        if not self.is_there:
            raise LostError(
                f"{self._title} is gone: nothing publishes {self._subscriber.resolved_name}"
            )

    def wait(self, limit_s: float) -> None:
        """Wait until it is connected, up to a limit of wall time [s].

        Raises:
            LostError: if it is not in time.
        """
        end = time.monotonic() + limit_s
        while not self.is_there and time.monotonic() < end and not rospy.is_shutdown():
            time.sleep(_LOOK_S)
        self.require()
