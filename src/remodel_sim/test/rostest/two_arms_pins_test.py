#!/usr/bin/env python3
"""Two arms place pins, and keep the contract of all abilities."""

import rospy
import rostest
from cell_clients import PINS, CellTestCase
from tf2_msgs.msg import TFMessage


class TwoArmsPinsTest(CellTestCase):
    abilities = ("PlacePin",)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.frames = set()
        rospy.Subscriber("/tf_static", TFMessage, cls.note_frames)

    @classmethod
    def note_frames(cls, message):
        cls.frames = {transform.child_frame_id for transform in message.transforms}

    def test_place_pin_keeps_the_contract_of_all_abilities(self):
        goal = str({key: value for key, value in PINS.items() if key != "show_in_TF"})
        report = self.check_conformance("PlacePin", goal)
        self.assertIn("ok          a cancel while the ability works", report)

    def test_pins_are_placed_and_shown(self):
        result = self.on["PlacePin"].do(**PINS)
        self.assertTrue(result.success, result.error_message)
        shares = self.on["PlacePin"].whole_progress()
        self.assertEqual(shares, sorted(shares))
        row = {"placepin/pin_1", "placepin/path_5", "placepin/pin_2"}
        self.assertLessEqual(row | {"panel", "robot_2_panda_link0"}, self.frames)


if __name__ == "__main__":
    rospy.init_node("test_two_arms_pins")
    rostest.rosrun("remodel_sim", "test_two_arms_pins", TwoArmsPinsTest)
