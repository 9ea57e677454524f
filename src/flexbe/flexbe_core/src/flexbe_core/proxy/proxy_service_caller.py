"""Call services from a state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import rospy
from genpy import Message

# [s] How long is_available and call wait for a service that was not there at set-up.
_RETRY_S = 1.0


class ProxyServiceCaller:
    """A handle on the service clients of the process."""

    _services: ClassVar[dict[str, rospy.ServiceProxy]] = {}

    def __init__(
        self,
        topics: Mapping[str, type] | None = None,
        persistent: bool = False,
        wait_duration: float = 10,
    ) -> None:
        for topic, service_type in (topics or {}).items():
            self.setupService(topic, service_type, persistent, wait_duration)

    def setupService(  # noqa: N802 - stock FlexBE's name
        self, topic: str, srv_type: type, persistent: bool = False, wait_duration: float = 10
    ) -> None:
        """Set up a service, unless the process did already; wait for it for `wait_duration` [s]."""
        if topic in self._services:
            return
        self._services[topic] = rospy.ServiceProxy(topic, srv_type, persistent)
        if not self._wait(topic, wait_duration):
            rospy.logerr("service %s is not there after %g s", topic, wait_duration)

    def is_available(self, topic: str) -> bool:
        """Return whether the service is there, within 1 s."""
        return topic in self._services and self._wait(topic, _RETRY_S)

    def call(self, topic: str, request: Message) -> Message:
        """Call the service and return its response.

        Raises:
            ValueError: if the service is not there.
            rospy.ServiceException: whatever the call raises.
        """
        if not self.is_available(topic):
            raise ValueError(f"cannot call service {topic}: it is not there")
        return self._services[topic].call(request)

    def _wait(self, topic: str, wait_duration: float) -> bool:
        try:
            self._services[topic].wait_for_service(wait_duration)
        except rospy.ROSException:
            return False
        return True
