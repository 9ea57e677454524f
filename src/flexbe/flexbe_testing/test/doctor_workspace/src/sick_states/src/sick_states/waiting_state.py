import subprocess

import actionlib
import rospy
from flexbe_core import EventState
from std_msgs.msg import String


class WaitingState(EventState):
    def __init__(self):
        super(WaitingState, self).__init__(outcomes=["done"])
        self._client = actionlib.SimpleActionClient("move", String)  # doctor: no-wake-up
        self._client.wait_for_server()

    def on_enter(self, userdata):
        rospy.wait_for_message("/go", String)  # doctor: wait
        subprocess.check_output(["true"])  # doctor: wait

    def execute(self, userdata):
        self._client.wait_for_result()  # doctor: wait
        return "done"
