"""An action server that outlives a ROS clock which is set back."""

from __future__ import annotations

import actionlib
import rospy


class SteadyActionServer(actionlib.ActionServer):
    """An action server that goes on publishing its status when `/clock` jumps back.

    The timer of actionlib's own server ends for ever then; clients then count the server as lost.
    """

    def initialize(self) -> None:
        """Set up the server, with a timer that survives."""
        super().initialize()
        if self.status_frequency > 0.0:
            self.status_timer.shutdown()
            period = rospy.Duration(1.0 / self.status_frequency)
            self.status_timer = rospy.Timer(period, self.publish_status_async, reset=True)
