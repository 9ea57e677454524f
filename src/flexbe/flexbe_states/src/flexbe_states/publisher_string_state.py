"""Publish a string."""

from std_msgs.msg import String

from flexbe_core import EventState
from flexbe_core.proxy import ProxyPublisher


class PublisherStringState(EventState):
    """Publish a string.

    -- topic  string  Topic to publish on.

    ># value  string  What to publish.

    <= done  It has been published.

    """

    def __init__(self, topic):
        super().__init__(outcomes=["done"], input_keys=["value"])
        self._topic = topic
        self._pub = ProxyPublisher({topic: String})

    def on_enter(self, userdata):
        """Publish."""
        self._pub.publish(self._topic, String(userdata.value))

    def execute(self, userdata):
        """Return at once."""
        return "done"
