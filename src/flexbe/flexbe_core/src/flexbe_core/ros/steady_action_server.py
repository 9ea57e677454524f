"""An action server that keeps working when the ROS clock is set back."""

from __future__ import annotations

import actionlib
import rospy


class SteadyActionServer(actionlib.ActionServer):
    """An action server that continues to publish its status when `/clock` jumps back.

    The timer of actionlib's own server ends then, and clients count the server as lost.
    """

    def initialize(self) -> None:
        """Set up the server, with a timer that survives."""
        super().initialize()
        if self.status_frequency > 0.0:
            self.status_timer.shutdown()
            period = rospy.Duration(1.0 / self.status_frequency)
            self.status_timer = rospy.Timer(period, self.publish_status_async, reset=True)
