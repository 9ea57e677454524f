"""Publish a bool."""

from std_msgs.msg import Bool

from flexbe_core import EventState
from flexbe_core.proxy import ProxyPublisher


class PublisherBoolState(EventState):
    """Publish a bool.

    -- topic  string  Topic to publish on.

    ># value  bool  What to publish.

    <= done  It has been published.

    """

    def __init__(self, topic):
        super().__init__(outcomes=["done"], input_keys=["value"])
        self._topic = topic
        self._pub = ProxyPublisher({topic: Bool})

    def on_enter(self, userdata):
        """Publish."""
        self._pub.publish(self._topic, Bool(userdata.value))

    def execute(self, userdata):
        """Return at once."""
        return "done"
