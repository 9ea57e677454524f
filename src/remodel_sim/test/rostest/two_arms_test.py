#!/usr/bin/env python3
"""The running cell with two arms as its clients meet it: one launch, the default panel, W1 fed."""

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from cell_clients import PINS, STOP_LIMIT_S, CellTestCase, wait_until
from remodel_msgs.msg import ErrorCode
from stop_watch import StopWatch


class TwoArmsTest(CellTestCase):
    abilities = ("PickCable", "PlacePin", "DetectCable")

    def test_cancel_stops_both_arms_within_a_fifth_of_a_second(self):
        pins, watch = self.on["PlacePin"], StopWatch("PlacePin")
        self.addCleanup(watch.close)
        pins.send(**PINS)
        self.assertTrue(
            wait_until(lambda: any("carrying" in f.message for f in pins.feedback)), "not carried"
        )
        pins.client.cancel_goal()
        self.assertTrue(wait_until(lambda: watch.took_s() is not None), "not stopped")
        self.assertLess(watch.took_s(), STOP_LIMIT_S)
        self.assertEqual(pins.wait().error_code, ErrorCode.PREEMPTED)
        self.assertEqual(pins.client.get_state(), GoalStatus.PREEMPTED)

    def test_each_arm_does_its_own_goal_at_the_same_time(self):
        pick, detect = self.on["PickCable"], self.on["DetectCable"]
        pick.send(robot_name="robot_2", cable_id="W1", cable_end="b")
        self.assertTrue(wait_until(lambda: pick.feedback))
        seen = detect.do(cable_id="W1")
        self.assertNotEqual(seen.error_code, ErrorCode.BUSY, "robot_1 is free for it")
        refused = self.on["PlacePin"].do(**PINS)
        self.assertEqual(refused.error_code, ErrorCode.BUSY, refused.error_message)
        self.assertIn("robot_2 is doing PickCable", refused.error_message)
        picked = pick.wait()
        self.assertTrue(picked.success, picked.error_message)

    def test_an_unknown_robot_is_refused_with_those_there_are(self):
        for fields in ({"robot_2_name": "robot_3"}, {"robot_1_name": ""}):
            result = self.on["PlacePin"].do(**{**PINS, **fields})
            self.assertEqual(result.error_code, ErrorCode.UNKNOWN_NAME)
            self.assertIn("there are: robot_1, robot_2", result.error_message)


if __name__ == "__main__":
    rospy.init_node("test_two_arms")
    rostest.rosrun("remodel_sim", "test_two_arms", TwoArmsTest)
