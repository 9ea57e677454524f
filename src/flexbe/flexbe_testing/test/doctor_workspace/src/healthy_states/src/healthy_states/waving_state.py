"""Wave."""

import rospy
from flexbe_core import EventState, Logger, wake_at
from flexbe_core.proxy import ProxyPublisher, ProxySubscriberCached, ProxyTransformListener
from std_msgs.msg import String


class WavingState(EventState):
    """Wave for a while.

    -- times  int  How often.

    <= done  It has waved.

    """

    def __init__(self, times, topic="wave", period_s=0.5):
        """Set up."""
        super().__init__(outcomes=["done"])
        self._topic = topic
        self._end = 0.0
        self._duration = times * period_s
        self._pub = ProxyPublisher({topic: String})
        self._sub = ProxySubscriberCached({topic: String})
        self._transforms = ProxyTransformListener().listener()
        self._frame = rospy.get_param("~frame")
        self.set_rate(20)

    def on_enter(self, userdata):
        """Begin."""
        self._end = rospy.get_time() + self._duration
        self._pub.publish(self._topic, String("wave"))

    def execute(self, userdata):
        """End when it is time."""
        if rospy.get_time() >= self._end or self._sub.has_msg(self._topic):
            Logger.loginfo("waved")
            return "done"
        wake_at(self._end)
        return None
