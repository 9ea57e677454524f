#!/usr/bin/env python3
"""Figure 3 of the deliverable, on the engine, in the physical cell."""

import threading
import time

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from place_connector_case import WALL_LIMIT_S, PlaceConnectorCase
from remodel_msgs.msg import ErrorCode, InsertCableActionFeedback
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty


class PlaceConnectorTest(PlaceConnectorCase):
    def test_clean(self):
        self.start()
        self.assertEqual(self.finish(), "finished")
        self.assert_abilities(
            ("LocateGearboxComponent", "located"),
            ("InsertCable", "inserted"),
            ("FixCable", "fixed"),
        )
        self.assertTrue(self.a_is_placed())

    def test_preempt_in_the_middle_of_an_insertion_stops_it(self):
        inserting = threading.Event()
        rospy.Subscriber(
            "remodel_abilities/insertcable/feedback",
            InsertCableActionFeedback,
            lambda message: message.feedback.completed_percentage > 30.0 and inserting.set(),
        )
        joints = []
        rospy.Subscriber("joint_states", JointState, joints.append)
        self.start()
        self.assertTrue(inserting.wait(WALL_LIMIT_S))
        asked = rospy.Time.now()
        self.preempt.publish(Empty())
        self.assertTrue(self.done.wait(WALL_LIMIT_S))
        took_s = (rospy.Time.now() - asked).to_sec()
        self.assertLess(took_s, 2.0, "half a second, and what a busy machine adds")
        self.assertEqual(self.client.get_state(), GoalStatus.PREEMPTED)
        self.assertEqual(self.client.get_result().outcome, "preempted")
        self.assert_abilities(("LocateGearboxComponent", "located"), ("InsertCable", ""))
        self.assertEqual(self.records[-1].error_code, ErrorCode.PREEMPTED)
        # The arm stands still: two joint states later than the stop are equal.
        before = len(joints)
        limit = time.monotonic() + WALL_LIMIT_S
        while len(joints) < before + 10 and time.monotonic() < limit:
            time.sleep(0.01)
        self.assertGreaterEqual(len(joints), before + 10)
        moved = max(
            abs(a - b)
            for a, b in zip(joints[before + 4].position, joints[-1].position, strict=True)
        )
        self.assertLess(moved, 1e-4)


if __name__ == "__main__":
    rospy.init_node("test_place_connector")
    rostest.rosrun("remodel_behaviors", "test_place_connector", PlaceConnectorTest)
