"""Send a goal, as stock FlexBE's documentation shows it."""

from actionlib.msg import TestAction, TestGoal

from flexbe_core import EventState, Logger
from flexbe_core.proxy import ProxyActionClient


class GoalState(EventState):
    """Send a goal and wait for its result.

    -- topic  string  Action topic.
    -- watch  bool    Check whether the server is still there.
    -- rate   float   How often it is executed [Hz], unless something wakes it.

    <= done    The server answered.
    <= failed  The goal could not be sent, or the server stopped.

    """

    def __init__(self, topic, watch=True, rate=10.0):
        """Connect to the server."""
        super().__init__(outcomes=["done", "failed"])
        self._topic = topic
        self._watch = watch
        self._client = ProxyActionClient({topic: TestAction}, wait_duration=2)
        self._error = False
        self.set_rate(rate)

    def on_enter(self, userdata):
        """Send the goal."""
        self._error = False
        try:
            self._client.send_goal(self._topic, TestGoal(goal=7))
        except ValueError as error:
            Logger.logwarn("cannot send the goal: %s", error)
            self._error = True

    def execute(self, userdata):
        """Check for the result."""
        if self._error:
            return "failed"
        if self._client.has_result(self._topic):
            return "done"
        if self._watch and not self._client.is_available(self._topic):
            return "failed"
        return None

    def on_exit(self, userdata):
        """Cancel what still runs."""
        Logger.loginfo("exit of the goal state")
        self._client.cancel(self._topic)

    def on_stop(self):
        """Log the end."""
        Logger.loginfo("stop of the goal state")
