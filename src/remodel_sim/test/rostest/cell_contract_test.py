#!/usr/bin/env python3
"""The running cell keeps the contract of all abilities, and recovers a component that moved."""

import rospy
import rostest
from cell_clients import OneWireCase, call
from remodel_msgs import srv
from remodel_msgs.msg import ErrorCode


class CellContractTest(OneWireCase):
    abilities = ("LocateGearboxComponent", "InsertCable", "ExtractCable")

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


if __name__ == "__main__":
    rospy.init_node("test_cell_contract")
    rostest.rosrun("remodel_sim", "test_cell_contract", CellContractTest)
