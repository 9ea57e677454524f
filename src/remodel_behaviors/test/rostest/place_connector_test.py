#!/usr/bin/env python3
"""Figure 3 of the deliverable, on the engine, in the physical cell."""

import threading
import time
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import BehaviorExecutionAction, BehaviorExecutionGoal
from flexbe_msgs.srv import GetUserdata
from remodel_msgs.msg import (
    AbilityRecord,
    ErrorCode,
    ExtractCableActionFeedback,
    InsertCableActionFeedback,
)
from remodel_msgs.srv import FeedWire, GetGroundTruth, InjectFault
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

WALL_LIMIT_S = 180.0
COMPONENT, TERMINAL, WIRE, CHANNEL = "X1", "1", "W1", "A"


class PlaceConnectorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = actionlib.SimpleActionClient(
            "flexbe/execute_behavior", BehaviorExecutionAction
        )
        cls.reset = rospy.ServiceProxy("cell/reset", Trigger)
        cls.feed = rospy.ServiceProxy("cell/feed_wire", FeedWire)
        cls.inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
        cls.truth = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)
        cls.reset.wait_for_service()
        cls.preempt = rospy.Publisher("/flexbe/commands/preempt", Empty, queue_size=1)
        assert cls.client.wait_for_server(rospy.Duration(60))

    def setUp(self):
        self.records = []
        self.on_record = None
        self.subscriber = rospy.Subscriber("remodel/ability_records", AbilityRecord, self._record)
        self.assertTrue(self.reset().success)
        response = self.feed(wire_id=WIRE, channel_id=CHANNEL)
        self.assertTrue(response.success, response.message)

    def tearDown(self):
        self.subscriber.unregister()

    def _record(self, record):
        self.records.append(record)
        if self.on_record:
            self.on_record(record)

    def start(self):
        self.done = threading.Event()
        self.client.send_goal(
            BehaviorExecutionGoal(behavior_name="Place Connector"),
            done_cb=lambda *_: self.done.set(),
        )

    def finish(self):
        self.assertTrue(self.done.wait(WALL_LIMIT_S), "the behavior did not end")
        return self.client.get_result().outcome

    def assert_abilities(self, *expected):
        """Check the records (ability, outcome); the last may arrive after the behavior's end."""
        limit = time.monotonic() + WALL_LIMIT_S
        while len(self.records) < len(expected) and time.monotonic() < limit:
            time.sleep(0.01)
        found = [(record.ability, record.outcome) for record in self.records]
        self.assertEqual(found, list(expected))

    def a_is_placed(self):
        (truth,) = [truth for truth in self.truth().wires if truth.wire_id == WIRE]
        return truth.a_at == f"{COMPONENT}/{TERMINAL}" and truth.a_fixed

    def test_clean(self):
        self.start()
        self.assertEqual(self.finish(), "finished")
        self.assert_abilities(
            ("LocateGearboxComponent", "located"),
            ("InsertCable", "inserted"),
            ("FixCable", "fixed"),
        )
        self.assertTrue(self.a_is_placed())

    def test_component_moved_after_it_was_located(self):
        def move_once(record):
            if record.ability == "LocateGearboxComponent":
                self.on_record = None
                response = self.inject("component_moved", COMPONENT, [0.0, 0.007, 0.0])
                self.assertTrue(response.success, response.message)

        self.on_record = move_once
        self.start()
        self.assertEqual(self.finish(), "finished")
        self.assert_abilities(
            ("LocateGearboxComponent", "located"),
            ("InsertCable", "failed"),
            ("ExtractCable", "extracted"),
            ("LocateGearboxComponent", "located"),
            ("InsertCable", "inserted"),
            ("FixCable", "fixed"),
        )
        self.assertIn(
            self.records[1].error_code,
            (
                ErrorCode.INSERTION_MISALIGNED,
                ErrorCode.INSERTION_NO_CONTACT,
            ),
        )
        self.assertTrue(self.a_is_placed())

    def test_a_blocked_socket_is_pushed_against_once_and_the_end_withdrawn(self):
        response = self.inject("socket_blocked", f"{COMPONENT}/{TERMINAL}", [])
        self.assertTrue(response.success, response.message)
        userdata = rospy.ServiceProxy("flexbe/get_userdata", GetUserdata)
        seen = {}

        def read(_):
            if not seen:
                for key in ("error_code", "error_message"):
                    for info in userdata(key).userdata:
                        seen[key] = info.data

        withdrawing = rospy.Subscriber(
            "remodel_abilities/extractcable/feedback", ExtractCableActionFeedback, read
        )
        self.addCleanup(withdrawing.unregister)
        self.start()
        self.assertEqual(self.finish(), "failed")
        self.assert_abilities(
            ("LocateGearboxComponent", "located"),
            ("InsertCable", "failed"),
            ("ExtractCable", "extracted"),
        )
        failure = self.records[1]
        self.assertEqual(failure.error_code, ErrorCode.INSERTION_JAMMED)
        self.assertTrue(failure.error_message)
        self.assertEqual(seen["error_code"], str(failure.error_code))
        self.assertEqual(seen["error_message"], failure.error_message)
        self.assertFalse(self.a_is_placed())

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
