import time

import rospy
from flexbe_core import EventState


class SleepingState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])
        time.sleep(100)  # in a constructor: not while a behavior runs

    def execute(self, userdata):
        time.sleep(0.5)  # doctor: sleep
        self._settle()
        return "done"

    def on_enter(self, userdata):
        rospy.sleep(1.0)  # doctor: sleep

    def _settle(self):
        rate = rospy.Rate(20)  # doctor: rate
        while not rospy.is_shutdown():  # doctor: loop
            rate.sleep()  # doctor: sleep

    def not_called_by_an_engine(self):
        time.sleep(1.0)
