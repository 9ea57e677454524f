"""What states find in the userdata and leave behind, as the engine publishes it."""

from __future__ import annotations

import rospy
from std_msgs.msg import String

from flexbe_core.engine.visit import VisitText
from remodel_console.ros import topics
from remodel_console.values import RunValues


class ValuesLink:
    """Subscribes to the visits of states."""

    def __init__(self, values: RunValues) -> None:
        """Keep `values` up to date."""
        self._values = values
        self._is_asking = False
        self._subscriber = self._subscribe()

    def _subscribe(self) -> rospy.Subscriber:
        """Subscribe; the engine sends all values first."""
        return rospy.Subscriber(topics.VISITS, String, self._take, tcp_nodelay=True)

    def _take(self, message: String) -> None:
        try:
            visit = VisitText.from_json(message.data)
        except (ValueError, TypeError, KeyError) as error:
            rospy.logwarn_once("%s has messages of another version: %s", topics.VISITS, error)
            return
        if self._values.take(visit):
            self._is_asking = False
        elif not self._is_asking:  # messages were lost
            self._is_asking = True
            self._subscriber.unregister()
            self._subscriber = self._subscribe()
