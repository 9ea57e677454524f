"""A state that an operator of the conformance kit opens and closes."""

from std_msgs.msg import String

from flexbe_core import EventState, Logger
from flexbe_core.proxy import ProxySubscriberCached


class GateState(EventState):
    """Return the outcome that was last received on a topic, and log every event.

    -- gate  string  The topic is conformance/GATE; an empty text closes the gate again.

    <= done   The gate was opened with this word.
    <= other  The gate was opened with this word.

    """

    def __init__(self, gate):
        """Subscribe to the topic of the gate."""
        super().__init__(outcomes=["done", "other"])
        self._gate_topic = f"conformance/{gate}"
        self._gate = ProxySubscriberCached({self._gate_topic: String})

    def execute(self, userdata):
        """Return what was received."""
        if not self._gate.has_msg(self._gate_topic):
            return None
        return self._gate.get_last_msg(self._gate_topic).data or None

    def on_start(self):
        """Log the event."""
        self._log("start")

    def on_stop(self):
        """Log the event."""
        self._log("stop")

    def on_enter(self, userdata):
        """Forget what was received for an earlier visit."""
        self._gate.remove_last_msg(self._gate_topic)
        self._log("enter")

    def on_exit(self, userdata):
        """Log the event."""
        self._log("exit")

    def on_pause(self):
        """Log the event."""
        self._log("pause")

    def on_resume(self, userdata):
        """Log the event."""
        self._log("resume")

    def _log(self, event):
        Logger.loginfo("conformance: %s %s", event, self.path)
