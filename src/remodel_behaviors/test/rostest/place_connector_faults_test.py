#!/usr/bin/env python3
"""Figure 3 of the deliverable where an insertion fails: recovered, or given up."""

import rospy
import rostest
from flexbe_msgs.srv import GetUserdata
from place_connector_case import COMPONENT, TERMINAL, PlaceConnectorCase
from remodel_msgs.msg import ErrorCode, ExtractCableActionFeedback


class PlaceConnectorFaultsTest(PlaceConnectorCase):
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


if __name__ == "__main__":
    rospy.init_node("test_place_connector_faults")
    rostest.rosrun("remodel_behaviors", "test_place_connector_faults", PlaceConnectorFaultsTest)
