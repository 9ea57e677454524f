#!/usr/bin/env python3
"""The running cell as its clients meet it: one launch, the default panel, wire W1 fed."""

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from cell_clients import STOP_LIMIT_S, WALL_LIMIT_S, OneWireCase, call, wait_until
from geometry_msgs.msg import PoseStamped, WrenchStamped
from remodel_msgs import msg, srv
from remodel_msgs.msg import ErrorCode
from stop_watch import StopWatch
from visualization_msgs.msg import MarkerArray


class CellTest(OneWireCase):
    abilities = (
        "LocateGearboxComponent",
        "InsertCable",
        "FixCable",
        "ExtractCable",
        "DetectCable",
        "PickCable",
        "CheckConnection",
        "PlaceConnector",
        "DiscardCable",
    )

    def test_it_says_what_it_is(self):
        self.assertEqual(rospy.get_param("/cell/cell_kind"), "simulated")

    def test_rviz_gets_the_scene_and_the_force(self):
        markers = rospy.wait_for_message("cell/markers", MarkerArray, WALL_LIMIT_S)
        names = {marker.ns for marker in markers.markers}
        self.assertLessEqual({"wire/W1", "component/X1"}, names)
        wrench = rospy.wait_for_message("cell/wrist/wrench", WrenchStamped, WALL_LIMIT_S)
        self.assertGreater(abs(wrench.wrench.force.z), 0.1, "the hand's weight")

    def test_a_fault_with_wrong_values_is_refused_with_the_right_ones(self):
        inject = rospy.ServiceProxy("cell/inject_fault", srv.InjectFault)
        response = inject("grip_weakened", "", [2.0])
        self.assertFalse(response.success)
        self.assertIn("allowed: 0.05 to 1", response.message)
        call("inject_fault", srv.InjectFault, kind="light_changed", values=[0.9])

    def test_a_frozen_server_does_nothing_and_then_goes_on(self):
        detect = self.on["DetectCable"]
        call("inject_fault", srv.InjectFault, kind="server_frozen", values=[4.0])
        detect.send(cable_id="W1")
        self.assertFalse(wait_until(lambda: detect.feedback or detect.ended(), 1.0))
        self.assertTrue(detect.wait().success)

    def test_goals_that_cannot_be_done_are_rejected_with_the_reason(self):
        insert, socket = self.on["InsertCable"], PoseStamped()
        socket.pose.position.x = float("nan")
        connector = {**self.at_terminal(), "connector_id": "P1", "force_limit": 30.0}
        connector["socket_pose"] = self.locate()
        cases = [
            ("InsertCable", self.insertion(socket), ErrorCode.INVALID_GOAL, "socket_pose holds"),
            ("LocateGearboxComponent", {"component_id": "Q9"}, ErrorCode.UNKNOWN_NAME, "X1, "),
            ("DetectCable", {"cable_id": "W1", "timeout": -1.0}, ErrorCode.INVALID_GOAL, "timeout"),
            ("DetectCable", {"cable_id": "W2"}, ErrorCode.WIRE_NOT_FED, "W1"),
            ("FixCable", self.at_terminal(), ErrorCode.NOTHING_HELD, "pick"),
            ("PlaceConnector", connector, ErrorCode.UNKNOWN_NAME, "'P1'; there are: none"),
        ]
        for name, fields, code, words in cases:
            result = self.on[name].do(**fields)
            self.assertEqual(self.on[name].client.get_state(), GoalStatus.REJECTED, name)
            self.assertEqual(result.error_code, code, name)
            self.assertIn(words, result.error_message)
            self.assertEqual(result.id, self.on[name].goal_id)
        self.assertEqual(insert.client.get_goal_status_text(), "socket_pose holds NaN or infinity")

    def test_goals_and_requests_of_an_older_owner_are_refused(self):
        call("feed_wire", srv.FeedWire, wire_id="W1", channel_id="A", owner=17)
        newer = self.on["DetectCable"].do(id="18:detect", cable_id="W1")
        self.assertTrue(newer.success, newer.error_message)
        for name, fields in (
            ("DetectCable", {"cable_id": "W1"}),
            ("LocateGearboxComponent", {"component_id": "X1"}),
        ):
            older = self.on[name].do(id="17:look", **fields)
            self.assertEqual(self.on[name].client.get_state(), GoalStatus.REJECTED)
            self.assertEqual(older.error_code, ErrorCode.STALE_OWNER, older.error_message)
            self.assertEqual(older.id, "17:look")
        feed = rospy.ServiceProxy("cell/feed_wire", srv.FeedWire)
        self.assertEqual(feed("W1", "A", 17).error_code, ErrorCode.STALE_OWNER)
        self.assertTrue(feed("", "", 19).success, "the cell rests, and changes hands")
        self.assertEqual(feed("W1", "A", 18).error_code, ErrorCode.STALE_OWNER)
        load_panel = rospy.ServiceProxy("cell/load_panel", srv.LoadPanel)
        load = load_panel(panel=msg.Panel(), owner=17)
        self.assertEqual((load.success, load.error_code), (False, ErrorCode.STALE_OWNER))
        load = load_panel(panel=msg.Panel(), owner=19)
        self.assertEqual((load.success, load.error_code), (False, ErrorCode.INVALID_GOAL))
        self.assertTrue(self.on["DetectCable"].do(cable_id="W1").success, "no owner: not checked")

    def test_a_second_goal_is_rejected_while_one_runs(self):
        self.on["LocateGearboxComponent"].send(component_id="X1", terminal_id="1")
        self.assertTrue(wait_until(lambda: self.on["LocateGearboxComponent"].feedback))
        result = self.on["DetectCable"].do(cable_id="W1")
        self.assertEqual(result.error_code, ErrorCode.BUSY)
        self.assertIn("test-LocateGearboxComponent", result.error_message)
        self.assertTrue(self.on["LocateGearboxComponent"].wait().success)

    def test_cancel_stops_the_arm_within_a_fifth_of_a_second(self):
        insert, watch = self.on["InsertCable"], StopWatch("InsertCable")
        self.addCleanup(watch.close)
        insert.send(**self.insertion(self.locate()))
        self.assertTrue(
            wait_until(lambda: any("carrying" in f.message for f in insert.feedback)), "not carried"
        )
        insert.client.cancel_goal()
        self.assertTrue(wait_until(lambda: watch.took_s() is not None), "not stopped")
        self.assertLess(watch.took_s(), STOP_LIMIT_S)
        self.assertEqual(insert.wait().error_code, ErrorCode.PREEMPTED)
        self.assertEqual(insert.client.get_state(), GoalStatus.PREEMPTED)
        again = self.on["PickCable"].do(robot_name="robot_1", cable_id="W1", cable_end="a")
        self.assertEqual(again.error_code, ErrorCode.OTHER_CABLE_HELD, "the wire stays held")

    def test_a_goal_keeps_its_timeout(self):
        result = self.on["DetectCable"].do(cable_id="W1", timeout=0.1)
        if not result.success:
            self.assertEqual(result.error_code, ErrorCode.TIMEOUT)
        located = self.on["LocateGearboxComponent"].do(component_id="X2", timeout=0.5)
        self.assertEqual(located.error_code, ErrorCode.TIMEOUT)
        self.assertEqual(self.on["LocateGearboxComponent"].client.get_state(), GoalStatus.ABORTED)


if __name__ == "__main__":
    rospy.init_node("test_cell")
    rostest.rosrun("remodel_sim", "test_cell", CellTest)
