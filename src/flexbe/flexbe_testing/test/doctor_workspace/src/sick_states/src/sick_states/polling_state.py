import rospy
from flexbe_core import EventState
from std_msgs.msg import String


class PollingState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])
        self._count = 0
        self._text = None
        self._subscriber = rospy.Subscriber("/text", String, self._on_text)  # doctor: no-wake-up

    def _on_text(self, message):
        self._text = message.data

    def on_enter(self, userdata):
        self._count = 0
        self._began = rospy.Time.now()

    def execute(self, userdata):
        self._count += 1  # doctor: counts-executions
        if self._count > 50:
            return "done"
        if rospy.Time.now() - self._began > rospy.Duration(5):  # doctor: polls-time
            return "done"
        return "done" if self._text else None
