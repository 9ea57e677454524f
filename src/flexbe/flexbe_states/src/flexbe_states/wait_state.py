"""Wait."""

import rospy

from flexbe_core import EventState, wake_at


class WaitState(EventState):
    """Wait for a time, in ROS time.

    -- wait_time  float  [s] How long to wait.

    <= done  The time has passed.

    """

    def __init__(self, wait_time):
        super().__init__(outcomes=["done"])
        self._wait = float(wait_time)
        self._start = 0.0

    def on_enter(self, userdata):
        """Note the time."""
        self._start = rospy.get_time()

    def execute(self, userdata):
        """Check whether the time has passed; otherwise request an execution for then."""
        now = rospy.get_time()
        if now < self._start:  # simulated time restarted
            self._start = now
        if now - self._start >= self._wait:
            return "done"
        wake_at(self._start + self._wait)
        return None
