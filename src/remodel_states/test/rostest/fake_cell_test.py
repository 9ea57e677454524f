#!/usr/bin/env python3
"""A fake cell keeps the contract, refuses what cannot be, and outlives its processes."""

import subprocess
import time
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from remodel_msgs import msg as remodel_msgs
from remodel_msgs.msg import Channel, Component, ErrorCode, Panel, Terminal, Wire
from remodel_msgs.srv import FeedWire, GetGroundTruth, InjectFault, LoadPanel, TakePicture
from roslib.packages import find_node
from std_srvs.srv import Trigger

from remodel_states.conformance.probe import Probe
from remodel_states.conformance.trial import Trials
from remodel_states.testing.world import Account, account
from remodel_states.testing.world_file import WorldFile

PANEL = Panel(
    name="two wires",
    components=[Component(id="Q1", terminals=[Terminal(id=str(n)) for n in range(1, 5)])],
    channels=[Channel(id="A")],
    wires=[
        Wire(id="W1", a_component="Q1", a_terminal="1", b_component="Q1", b_terminal="2"),
        Wire(id="W2", a_component="Q1", a_terminal="3", b_component="Q1", b_terminal="4"),
    ],
)
ABILITIES = (
    "CheckConnection",
    "DiscardCable",
    "ExtractCable",
    "FixCable",
    "InsertCable",
    "LocateGearboxComponent",
    "PlaceCable",
)
ENDS = {("W1", "a"): "1", ("W1", "b"): "2", ("W2", "a"): "3", ("W2", "b"): "4"}


def call(name, service_type, /, **request):
    rospy.wait_for_service(name, 90.0)
    return rospy.ServiceProxy(name, service_type)(**request)


class FakeCellTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world = WorldFile(rospy.get_param("world"))
        cls.screwdriver = None
        cls.clients = {}
        for ability in ABILITIES:
            kind = getattr(remodel_msgs, f"{ability}Action")
            cls.clients[ability] = actionlib.SimpleActionClient(
                f"remodel_abilities/{ability.lower()}", kind
            )
        cls.restart_screwdriver()
        for client in cls.clients.values():
            assert client.wait_for_server(rospy.Duration(90.0))

    @classmethod
    def tearDownClass(cls):
        cls.screwdriver.kill()
        cls.screwdriver.wait()

    @classmethod
    def restart_screwdriver(cls):
        """Kill the server of FixCable, and restart it."""
        if cls.screwdriver:
            cls.screwdriver.kill()
            cls.screwdriver.wait()
        words = ["__name:=screwdriver", f"_world:={rospy.get_param('world')}", "_services:=false"]
        node = find_node("remodel_states", "fake_cell")[0]
        cls.screwdriver = subprocess.Popen([node, *words, "_abilities:=[FixCable]"])
        client = actionlib.SimpleActionClient(
            "remodel_abilities/fixcable", remodel_msgs.FixCableAction
        )
        assert client.wait_for_server(rospy.Duration(90.0))
        cls.clients["FixCable"] = client

    def setUp(self):
        self.count = 0
        self.assertTrue(call("cell/load_panel", LoadPanel, panel=PANEL).success)

    def goal(self, ability, wire="W1", end="a", owner=""):
        self.count += 1
        goal = getattr(remodel_msgs, f"{ability}Goal")(timeout=5.0)
        goal.id = f"{owner}{ability}#{self.count}"
        known = {
            "robot_name": "robot_1",
            "cable_id": wire,
            "cable_end": end,
            "component_id": "Q1",
            "terminal_id": ENDS.get((wire, end), ""),
            "force_limit": 8.0,
            "socket_pose": PoseStamped(),
        }
        for name in set(known) & set(goal.__slots__):
            setattr(goal, name, known[name])
        return goal

    def ask(self, ability, *about, owner="", view=0):
        """Return the result of a goal; None if the server went away."""
        client = self.clients[ability]
        goal = self.goal(ability, *about, owner=owner)
        if view:
            goal.view = view
        client.send_goal(goal)
        client.wait_for_result(rospy.Duration(90.0))
        return client.get_result()

    def feed(self, wire):
        self.assertTrue(call("cell/feed_wire", FeedWire, wire_id=wire, channel_id="A").success)

    def test_wires_are_placed_and_the_truth_is_returned(self):
        for wire in ("W1", "W2"):
            self.feed(wire)
            for end in "ab":
                self.assertTrue(self.ask("InsertCable", wire, end).success)
                self.assertFalse(self.ask("CheckConnection", wire, end).connected)
                self.assertTrue(self.ask("FixCable", wire, end).success)
                self.assertTrue(self.ask("CheckConnection", wire, end).connected)
        truths = call("cell/ground_truth", GetGroundTruth).wires
        self.assertEqual([(t.wire_id, t.placed) for t in truths], [("W1", True), ("W2", True)])
        self.assertEqual((truths[0].a_at, truths[0].a_fixed), ("Q1/1", True))
        self.assertEqual(call("cell/take_picture", TakePicture, camera="scene").image.height, 6)

    def test_what_cannot_be_is_refused_by_its_code(self):
        self.assertEqual(self.ask("InsertCable").error_code, ErrorCode.WIRE_NOT_FED)
        self.feed("W1")
        self.assertEqual(self.ask("FixCable").error_code, ErrorCode.NOTHING_HELD)
        self.ask("InsertCable")
        refused = call("cell/feed_wire", FeedWire, wire_id="W2", channel_id="A")
        self.assertEqual(refused.error_code, ErrorCode.OTHER_CABLE_HELD)
        self.assertFalse(call("cell/take_picture", TakePicture, camera="none").success)

    def test_a_fault_lasts_until_its_cure(self):
        caused = call(
            "cell/inject_fault", InjectFault, kind="insertion_jammed", target="new_part/W1"
        )
        self.assertTrue(caused.success, caused.message)
        for wrong in ({"kind": "nonesuch"}, {"kind": "slipped", "target": "prayer"}):
            self.assertFalse(call("cell/inject_fault", InjectFault, **wrong).success)
        self.feed("W1")
        codes = [self.ask("InsertCable").error_code for _ in range(3)]
        self.assertEqual(codes, [ErrorCode.INSERTION_JAMMED] * 3)
        held = call("cell/feed_wire", FeedWire, wire_id="W1", channel_id="A")
        self.assertEqual(held.error_code, ErrorCode.OTHER_CABLE_HELD)
        self.assertTrue(self.ask("PlaceCable", "").success)
        left_behind = call("cell/feed_wire", FeedWire, wire_id="W1", channel_id="A")
        self.assertEqual(left_behind.error_code, ErrorCode.WIRE_LEFT_BEHIND)
        self.assertTrue(self.ask("DiscardCable").success)
        self.feed("W1")
        self.assertTrue(self.ask("InsertCable").success)

    def test_feeding_an_untouched_wire_feeds_no_new_piece(self):
        for _ in range(2):
            self.feed("W1")
        self.assertEqual(account(self.world.ledger(), ["W1"]).fed_again, ())

    def test_another_view_cures_what_the_usual_one_does_not(self):
        call("cell/inject_fault", InjectFault, kind="component_occluded", target="look_again")
        codes = [self.ask("LocateGearboxComponent").error_code for _ in range(2)]
        self.assertEqual(codes, [ErrorCode.COMPONENT_OCCLUDED] * 2)
        self.assertTrue(self.ask("LocateGearboxComponent", view=1).success)

    def test_a_stuck_wire_stays_until_an_operator_frees_it(self):
        call("cell/inject_fault", InjectFault, kind="extraction_stuck", target="ask_operator")
        self.feed("W1")
        self.assertTrue(self.ask("DiscardCable").success)  # nothing of it is connected
        self.feed("W1")
        self.ask("InsertCable")
        self.ask("FixCable")
        for ability in ("ExtractCable", "DiscardCable"):
            self.assertEqual(self.ask(ability).error_code, ErrorCode.EXTRACTION_STUCK)
        self.assertTrue(self.ask("CheckConnection").connected)
        self.assertIn("extraction_stuck", call("cell/mend_faults", Trigger).message)
        self.assertTrue(self.ask("DiscardCable").success)
        self.assertEqual(call("cell/ground_truth", GetGroundTruth).wires, [])
        self.assertEqual(account(self.world.ledger(), ["W1"]).scrapped, ("W1",))

    def test_a_panel_is_kept_only_with_its_serial_number(self):
        for serial, kept in (("house-1", False), ("house-1", True), ("house-2", False)):
            panel = Panel(**{name: getattr(PANEL, name) for name in PANEL.__slots__})
            panel.serial = serial
            loaded = call("cell/load_panel", LoadPanel, panel=panel, keep=True)
            self.assertTrue(loaded.success)
            self.assertEqual(bool(call("cell/ground_truth", GetGroundTruth).wires), kept)
            self.feed("W1")
        wrong = Panel(wires=[Wire(id="W1", a_component="X")])
        self.assertEqual(
            call("cell/load_panel", LoadPanel, panel=wrong).error_code, ErrorCode.INVALID_GOAL
        )

    def test_goals_that_the_robot_cannot_do_are_refused_with_the_panel(self):
        self.assertTrue(call("cell/load_panel", LoadPanel, panel=PANEL).success)
        demands = {"robots": ["robot_9"], "abilities": ["InsertCable"], "force_limits": [61.0]}
        refused = call("cell/load_panel", LoadPanel, panel=Panel(name="other"), **demands)
        self.assertEqual(refused.error_code, ErrorCode.INVALID_GOAL)
        self.assertIn("robot 'robot_9'; the cell has robot_1, robot_2", refused.message)
        self.assertIn("up to 61 N; this cell's grip holds at most 60 N", refused.message)
        self.feed("W1")  # the panel of before is there

    def test_an_older_supervisor_is_refused_even_by_another_process(self):
        self.assertTrue(call("cell/load_panel", LoadPanel, panel=PANEL, owner=1).success)
        self.feed("W1")
        self.assertTrue(self.ask("InsertCable", owner="2:").success)
        self.restart_screwdriver()
        stale = self.ask("FixCable", owner="1:")
        self.assertEqual(stale.error_code, ErrorCode.STALE_OWNER)
        self.assertIn("supervisor 2 does", stale.error_message)
        fed = call("cell/feed_wire", FeedWire, wire_id="W2", channel_id="A", owner=1)
        loaded = call("cell/load_panel", LoadPanel, panel=PANEL, owner=1)
        self.assertEqual([fed.error_code, loaded.error_code], [ErrorCode.STALE_OWNER] * 2)
        self.assertTrue(self.ask("FixCable", owner="2:").success)
        self.assertTrue(call("cell/load_panel", LoadPanel, panel=PANEL).success)

    def test_a_goal_of_a_cell_that_changes_hands_meanwhile_has_no_effect(self):
        client = actionlib.SimpleActionClient(
            "slow/remodel_abilities/insertcable", remodel_msgs.InsertCableAction
        )
        self.assertTrue(client.wait_for_server(rospy.Duration(90.0)))
        call("slow/cell/load_panel", LoadPanel, panel=PANEL, owner=1)
        call("slow/cell/feed_wire", FeedWire, wire_id="W1", channel_id="A", owner=1)
        client.send_goal(self.goal("InsertCable", owner="1:"))
        # Not active_cb: SimpleActionClient drops a transition that comes while it sends the goal.
        end_s = time.monotonic() + 90.0
        while client.get_state() != GoalStatus.ACTIVE:
            self.assertLess(time.monotonic(), end_s)
            time.sleep(0.005)
        loaded = call("slow/cell/load_panel", LoadPanel, panel=PANEL, owner=2)
        self.assertEqual(loaded.error_code, ErrorCode.BUSY)
        taken_over = call("slow/cell/feed_wire", FeedWire, owner=2)
        self.assertEqual(taken_over.error_code, ErrorCode.BUSY)
        self.assertTrue(client.wait_for_result(rospy.Duration(90.0)))
        self.assertEqual(client.get_result().error_code, ErrorCode.STALE_OWNER)
        self.assertTrue(call("slow/cell/feed_wire", FeedWire, owner=2).success)

    def test_a_server_misbehaves_as_requested(self):
        client = self.clients["FixCable"]
        self.feed("W1")
        self.ask("InsertCable")
        call("cell/inject_fault", InjectFault, kind="server_hung")
        client.send_goal(self.goal("FixCable"))
        self.assertFalse(client.wait_for_result(rospy.Duration(0.5)))
        client.cancel_goal()
        self.assertTrue(client.wait_for_result(rospy.Duration(90.0)))
        self.assertEqual(client.get_result().error_code, ErrorCode.PREEMPTED)
        self.assertTrue(call("cell/load_panel", LoadPanel, panel=PANEL).success)
        self.feed("W1")
        self.ask("InsertCable")
        call("cell/inject_fault", InjectFault, kind="result_contradictory")
        result = self.ask("FixCable")
        self.assertTrue(result.success)
        self.assertEqual(result.error_code, ErrorCode.INTERNAL)

    def test_no_deed_is_lost_or_done_twice_when_its_server_is_killed(self):
        for number, (wire, end) in enumerate(ENDS):
            if end == "a":
                self.feed(wire)
            self.assertTrue(self.ask("InsertCable", wire, end).success)
            self.clients["FixCable"].send_goal(self.goal("FixCable", wire, end))
            self.clients["FixCable"].wait_for_result(rospy.Duration(0.005 * number))
            self.restart_screwdriver()
            if not self.ask("CheckConnection", wire, end).connected:
                self.assertTrue(self.ask("FixCable", wire, end).success)
        found = account(self.world.ledger(), ["W1", "W2"])
        self.assertEqual(found, Account((), (), (), ()))

    def test_a_slow_server_keeps_the_contract(self):
        self.assertTrue(call("slow/cell/load_panel", LoadPanel, panel=PANEL).success)
        probe = Probe("slow/remodel_abilities/checkconnection", remodel_msgs.CheckConnectionAction)
        trials = list(Trials(probe, self.goal("CheckConnection"), range(500)).run(20.0))
        self.assertEqual([trial for trial in trials if trial.faults], [])
        judged = [trial for trial in trials if not trial.unjudged]
        self.assertGreater(len(judged), 10)


if __name__ == "__main__":
    rospy.init_node("test_fake_cell")
    rostest.rosrun("remodel_states", "test_fake_cell", FakeCellTest)
