"""Publish from a state."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import ClassVar

import rospy
from genpy import Message

from flexbe_core.ros.master import is_heard

# [s] Wall time after which waiting for a subscriber is logged.
_LOG_AFTER_S = 0.5

# [s] Wall time between two checks whether there is a subscriber.
_CHECK_EVERY_S = 0.02


class ProxyPublisher:
    """A handle on the publishers of the process."""

    _publishers: ClassVar[dict[str, rospy.Publisher]] = {}

    def __init__(
        self,
        topics: Mapping[str, type[Message]] | None = None,
        _latch: bool = False,
        _queue_size: int = 100,
    ) -> None:
        for topic, message_type in (topics or {}).items():
            self.createPublisher(topic, message_type, _latch, _queue_size)

    def createPublisher(  # noqa: N802 - stock FlexBE's name
        self, topic: str, msg_type: type[Message], _latch: bool = False, _queue_size: int = 100
    ) -> None:
        """Advertise a topic, unless the process does already."""
        if topic not in self._publishers:
            self._publishers[topic] = rospy.Publisher(
                topic, msg_type, latch=_latch, queue_size=_queue_size
            )

    def is_available(self, topic: str) -> bool:
        """Return whether the topic is advertised."""
        return topic in self._publishers

    def publish(self, topic: str, msg: Message) -> None:
        """Publish a message; a failure is only logged as a warning."""
        publisher = self._publishers.get(topic)
        if publisher is None:
            rospy.logwarn("cannot publish on %s: no publisher was created for it", topic)
            return
        try:
            publisher.publish(msg)
        except Exception as error:  # noqa: BLE001 - stock FlexBE's promise to states
            rospy.logwarn("cannot publish on %s: %s", topic, error)

    def wait_for_any(self, topic: str, timeout: float = 5.0) -> bool:
        """Wait for a subscriber, at most `timeout` [s] of wall time."""
        publisher = self._publishers.get(topic)
        if publisher is None:
            rospy.logerr("cannot wait for %s: no publisher was created for it", topic)
            return False
        start = time.monotonic()
        is_logged = False
        while not is_heard(publisher):
            waited = time.monotonic() - start
            if waited >= timeout or rospy.is_shutdown():
                rospy.logerr("no subscriber of %s within %g s", topic, timeout)
                return False
            if not is_logged and waited > _LOG_AFTER_S:
                is_logged = True
                rospy.logwarn("waiting up to %g s for a subscriber of %s", timeout, topic)
            time.sleep(_CHECK_EVERY_S)
        if is_logged:
            rospy.loginfo("%s has a subscriber", topic)
        return True
