#!/usr/bin/env python3
"""The server of InsertCable pushes by the wrenches that were recorded during two pushes.

The bags hold the goal, the wrenches and the result of a push in the simulated cell, as
`rosbag record /cell/wrist/wrench /remodel_abilities/insertcable/goal
/remodel_abilities/insertcable/result` writes them: of an end that seats, and of one beside its
opening. Bags of a real arm take their place. The arm of this test plays them by depth: it measures
what was measured where its equilibrium pose is.
"""

import unittest
from bisect import bisect_right
from pathlib import Path

import actionlib
import rosbag
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, WrenchStamped
from remodel_msgs.msg import ErrorCode, InsertCableAction, InsertCableGoal

from flexbe_core.testing import wait_until

RECORDED = Path(__file__).parents[1] / "recorded"
# Of the recorded arm: [m/s] in the opening, and before it; of the server: [m] flange to tip.
INSIDE_M_S, BEFORE_M_S, TIP_M = 0.01, 0.04, 0.20
# [N] The recorded arm stopped itself at 8 N, between two of the messages that it publishes.
FORCE_LIMIT = 7.0
LIMIT = rospy.Duration(90)
# After so many wrenches the server has forgotten those of the push before: it keeps the last one.
FORGOTTEN = 3


class Recording:
    """A push: its goal, its result, and the wrench at each depth of the tip."""

    def __init__(self, name):
        with rosbag.Bag(str(RECORDED / f"{name}.bag")) as bag:
            messages = [(topic, message) for topic, message, _ in bag.read_messages()]
        (self.goal,) = (m.goal for topic, m in messages if topic.endswith("/goal"))
        self.goal.force_limit = FORCE_LIMIT
        (result,) = (m for topic, m in messages if topic.endswith("/result"))
        self.result, end = result.result, result.header.stamp
        wrenches = [m for topic, m in messages if topic.endswith("/wrench")]
        self.wrenches = [m for m in wrenches if m.header.stamp <= end]
        self.depths = [self.depth(end - m.header.stamp) for m in self.wrenches]

    def depth(self, before_end):
        """Return where the tip was [m], some time before the end of the push."""
        inside = self.result.depth - INSIDE_M_S * before_end.to_sec()
        return inside if inside > 0.0 else inside * BEFORE_M_S / INSIDE_M_S

    def at(self, depth_m):
        """Return the wrench at a depth [m]."""
        return self.wrenches[max(0, bisect_right(self.depths, depth_m) - 1)]


class Arm:
    """An arm that measures what was recorded where it is sent."""

    def __init__(self):
        self.play("seats")
        self.wrench = rospy.Publisher("arm/wrench", WrenchStamped, queue_size=10)
        rospy.Subscriber("arm/equilibrium_pose", PoseStamped, self.on_pose, tcp_nodelay=True)
        self.timer = rospy.Timer(rospy.Duration(0.05), lambda _: self.measure())

    def play(self, name):
        self.recording, self.is_silent, self.depths = Recording(name), False, []
        self.measured = 0

    def on_pose(self, pose):
        opening = self.recording.goal.socket_pose.pose
        # The openings of the recorded panel point along -x of the world.
        self.depths.append(opening.position.x - pose.pose.position.x + TIP_M)
        self.measure()

    def measure(self):
        if not self.is_silent:
            self.wrench.publish(self.recording.at(self.depths[-1] if self.depths else -1.0))
            self.measured += 1


class InsertCableTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.arm = Arm()
        topic = "remodel_abilities/insertcable"
        cls.client, cls.slow = (
            actionlib.SimpleActionClient(f"{namespace}{topic}", InsertCableAction)
            for namespace in ("", "slow/")
        )
        for client in (cls.client, cls.slow):
            assert client.wait_for_server(LIMIT)
        assert wait_until(lambda: cls.arm.wrench.get_num_connections() > 1)

    def begin(self, name, client=None):
        """Send a recorded goal, again while the server has not heard the arm yet."""
        client = client or self.client
        self.arm.play(name)
        self.assertTrue(wait_until(lambda: self.arm.measured >= FORGOTTEN))
        client.send_goal(self.arm.recording.goal)

        def has_begun():
            if client.get_state() == GoalStatus.REJECTED:
                client.send_goal(self.arm.recording.goal)
            return bool(self.arm.depths)

        self.assertTrue(wait_until(has_begun))

    def push(self, name):
        """Do a recorded goal; return the result."""
        self.begin(name)
        self.assertTrue(self.client.wait_for_result(LIMIT))
        return self.client.get_result()

    def test_an_end_that_seated_seats(self):
        result = self.push("seats")
        recorded = self.arm.recording.result
        self.assertTrue(result.success, result.error_message)
        self.assertAlmostEqual(result.depth, recorded.depth, delta=0.001)
        self.assertAlmostEqual(result.peak_force, recorded.peak_force, delta=1.0)

    def test_an_end_that_met_the_face_is_misaligned(self):
        result = self.push("beside")
        self.assertEqual(result.error_code, ErrorCode.INSERTION_MISALIGNED)
        self.assertEqual(self.arm.recording.result.error_code, ErrorCode.INSERTION_MISALIGNED)
        # Before the opening the recorded arm went 4 mm from one message to the next.
        self.assertAlmostEqual(result.depth, self.arm.recording.result.depth, delta=0.005)

    def test_a_cancel_holds_the_arm_where_it_is(self):
        self.begin("seats")
        self.assertTrue(wait_until(lambda: self.arm.depths[-1] > 0.002))
        self.client.cancel_goal()
        self.assertTrue(self.client.wait_for_result(LIMIT))
        self.assertEqual(self.client.get_result().error_code, ErrorCode.PREEMPTED)
        self.assertLess(max(self.arm.depths), self.arm.recording.result.depth)
        self.assertEqual(self.arm.depths[-1], max(self.arm.depths))

    def test_a_push_ends_when_the_wrench_does(self):
        self.begin("seats", self.slow)
        self.assertTrue(wait_until(lambda: self.arm.depths[-1] > 0.002))
        self.arm.is_silent = True
        self.assertTrue(self.slow.wait_for_result(LIMIT))
        result = self.slow.get_result()
        self.assertEqual(result.error_code, ErrorCode.MOTION_FAULT)
        self.assertRegex(result.error_message, "no wrench on /arm/wrench for [4-9]")
        self.slow.send_goal(self.arm.recording.goal)
        self.assertTrue(self.slow.wait_for_result(LIMIT))
        self.assertIn("start the controllers", self.slow.get_result().error_message)

    def test_a_goal_without_a_force_limit_is_refused(self):
        self.client.send_goal(InsertCableGoal(id="g", timeout=10.0))
        self.assertTrue(self.client.wait_for_result(LIMIT))
        self.assertEqual(self.client.get_result().error_code, ErrorCode.INVALID_GOAL)


if __name__ == "__main__":
    rospy.init_node("test_insert_cable")
    rostest.rosrun("remodel_robot", "test_insert_cable", InsertCableTest)
