"""Publish a signal."""

from std_msgs.msg import Empty

from flexbe_core import EventState
from flexbe_core.proxy import ProxyPublisher


class PublisherEmptyState(EventState):
    """Publish an empty message.

    -- topic  string  Topic to publish on.

    <= done  It has been published.

    """

    def __init__(self, topic):
        super().__init__(outcomes=["done"])
        self._topic = topic
        self._pub = ProxyPublisher({topic: Empty})

    def on_enter(self, userdata):
        """Publish."""
        self._pub.publish(self._topic, Empty())

    def execute(self, userdata):
        """Return at once."""
        return "done"
