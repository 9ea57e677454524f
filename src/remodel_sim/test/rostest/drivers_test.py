#!/usr/bin/env python3
"""The skills of one process wire by the drivers of another, over topics and services alone."""

import rospy
import rostest
from cell_clients import OneWireCase, call
from remodel_msgs import srv

LIMIT_N = 8.0


class DriversTest(OneWireCase):
    abilities = ("LocateGearboxComponent", "InsertCable", "FixCable", "CheckConnection")

    def test_a_wire_end_is_inserted_and_fixed_over_topics(self):
        inserted = self.on["InsertCable"].do(**self.insertion(self.locate()))
        self.assertTrue(inserted.success, inserted.error_message)
        self.assertLessEqual(inserted.peak_force, 1.15 * LIMIT_N + 0.5)
        fixed = self.on["FixCable"].do(**self.at_terminal(), pull_test_force=10.0)
        self.assertTrue(fixed.success, fixed.error_message)
        truth = call("ground_truth", srv.GetGroundTruth).wires[0]
        self.assertEqual((truth.a_at, truth.a_fixed), ("X1/1", True))
        seen = self.on["CheckConnection"].do(
            cable_id="W1", cable_end="a", component_id="X1", terminal_id="1"
        )
        self.assertTrue(seen.success and seen.connected, seen.error_message or seen.message)


if __name__ == "__main__":
    rospy.init_node("test_drivers")
    rostest.rosrun("remodel_sim", "test_drivers", DriversTest)
