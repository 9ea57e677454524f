#!/usr/bin/env python3
"""The running cell keeps the contract of all abilities, and does what a whole task needs."""

import rospy
import rostest
from cell_clients import OneWireCase, call
from remodel_msgs import srv
from remodel_msgs.msg import ErrorCode


class CellContractTest(OneWireCase):
    abilities = (
        "LocateGearboxComponent",
        "InsertCable",
        "FixCable",
        "ExtractCable",
        "DetectCable",
        "PickCable",
        "CheckConnection",
        "DiscardCable",
    )

    def test_its_servers_keep_the_contract(self):
        report = self.check_conformance(
            "LocateGearboxComponent", "{component_id: X1, terminal_id: '1'}"
        )
        self.assertIn("ok          a cancel while the ability works", report)
        self.check_conformance("DiscardCable", "{robot_name: robot_1, cable_id: W1}")
        self.setUp()
        self.check_conformance("DetectCable", "{cable_id: W1}")
        at_x1 = "{cable_id: W1, cable_end: a, component_id: X1, terminal_id: '1'}"
        self.check_conformance("CheckConnection", at_x1)

    def test_a_moved_component_fails_the_insertion_and_recovery_succeeds(self):
        socket = self.locate()
        call(
            "inject_fault",
            srv.InjectFault,
            kind="component_moved",
            target="X1",
            values=[0.0, 0.006, 0.0],
        )
        failed = self.on["InsertCable"].do(**self.insertion(socket))
        self.assertEqual(failed.error_code, ErrorCode.INSERTION_MISALIGNED, failed.error_message)
        out = self.on["ExtractCable"].do(**self.at_terminal(), socket_pose=socket)
        self.assertTrue(out.success, out.error_message)
        inserted = self.on["InsertCable"].do(**self.insertion(self.locate()))
        self.assertTrue(inserted.success, inserted.error_message)

    def test_a_wire_end_is_located_inserted_and_fixed(self):
        seen = self.on["DetectCable"].do(cable_id="W1").observation
        self.assertEqual(len(seen.tips), 2)
        inserted = self.on["InsertCable"].do(**self.insertion(self.locate()))
        self.assertTrue(inserted.success, inserted.error_message)
        self.assertGreater(inserted.elapsed_time, 1.0)
        shares = self.on["InsertCable"].whole_progress()
        self.assertEqual(shares, sorted(shares))
        fixed = self.on["FixCable"].do(**self.at_terminal(), pull_test_force=10.0)
        self.assertTrue(fixed.success, fixed.error_message)
        truth = call("ground_truth", srv.GetGroundTruth).wires[0]
        self.assertEqual((truth.a_at, truth.a_fixed, truth.placed), ("X1/1", True, False))
        for end, component, connected in (("a", "X1", True), ("b", "X2", False)):
            seen = self.on["CheckConnection"].do(
                cable_id="W1", cable_end=end, component_id=component, terminal_id="1"
            )
            self.assertTrue(seen.success, seen.error_message)
            self.assertEqual(seen.connected, connected, seen.message)

    def test_the_wire_in_the_hand_is_discarded_and_a_new_piece_is_fed(self):
        picked = self.on["PickCable"].do(robot_name="robot_1", cable_id="W1", cable_end="a")
        self.assertTrue(picked.success, picked.error_message)
        feed = rospy.ServiceProxy("cell/feed_wire", srv.FeedWire)
        self.assertEqual(feed("W1", "A", 0).error_code, ErrorCode.OTHER_CABLE_HELD)
        discarded = self.on["DiscardCable"].do(robot_name="robot_1")
        self.assertTrue(discarded.success, discarded.error_message)
        self.assertEqual(call("ground_truth", srv.GetGroundTruth).wires, [])
        self.assertEqual(
            self.on["DiscardCable"].do(robot_name="robot_1").error_code, ErrorCode.NOTHING_HELD
        )
        call("feed_wire", srv.FeedWire, wire_id="W1", channel_id="A")
        self.assertTrue(self.on["DetectCable"].do(cable_id="W1", view=1).success)


if __name__ == "__main__":
    rospy.init_node("test_cell_contract")
    rostest.rosrun("remodel_sim", "test_cell_contract", CellContractTest)
