"""An action server that keeps working when the ROS clock is set back, and ends quietly."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import actionlib
import rospy
from actionlib_msgs.msg import GoalID
from genpy import Message

from flexbe_core.ros.master import is_late_publication


class SteadyActionServer(actionlib.ActionServer):
    """An action server that continues to publish its status when `/clock` jumps back.

    The timer of actionlib's own server ends then, and clients count the server as lost. A goal that
    arrives while ROS closes the topics is dropped: no client would get an answer.
    """

    def initialize(self) -> None:
        """Set up the server, with a timer that survives."""
        super().initialize()
        if self.status_frequency > 0.0:
            self.status_timer.shutdown()
            period = rospy.Duration(1.0 / self.status_frequency)
            self.status_timer = rospy.Timer(period, self.publish_status_async, reset=True)

    def internal_goal_callback(self, goal: Message) -> None:
        """Handle a goal that has arrived."""
        with _without_late_publications():
            super().internal_goal_callback(goal)

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Handle a cancel that has arrived."""
        with _without_late_publications():
            super().internal_cancel_callback(goal_id)


@contextmanager
def _without_late_publications() -> Iterator[None]:
    try:
        yield
    except rospy.ROSException as error:
        if not is_late_publication(error):
            raise
