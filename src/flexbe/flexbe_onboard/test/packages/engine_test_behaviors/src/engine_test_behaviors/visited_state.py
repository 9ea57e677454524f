"""A state that publishes when it is entered and left."""

from std_msgs.msg import String

from flexbe_core import EventState
from flexbe_core.proxy import ProxyPublisher

TOPIC = "test/visits"


class VisitedState(EventState):
    """Return `done` after some executions, at 200 Hz."""

    def __init__(self, waits):
        super().__init__(outcomes=["done"])
        self.set_rate(200)
        self._waits = self._left = waits
        self._visits = ProxyPublisher()
        self._visits.createPublisher(TOPIC, String, _queue_size=10_000)

    def on_enter(self, userdata):
        self._left = self._waits
        self._visits.publish(TOPIC, String(f"enter {self.path}"))

    def execute(self, userdata):
        self._left -= 1
        return "done" if self._left < 0 else None

    def on_exit(self, userdata):
        self._visits.publish(TOPIC, String(f"exit {self.path}"))
