#!/usr/bin/env python3
"""Nothing moves after a motion fault of which a killed process did not learn."""

import os
import signal

import rospy
import rostest
from order_client import wait_until
from remodel_msgs.msg import (
    ErrorCode,
    LayWireActionGoal,
    LayWireActionResult,
    OperatorQuestion,
)
from supervision_case import SupervisionCase

from remodel_states.edge.exported_tables import read_abilities


class SupervisionFaultsTest(SupervisionCase):
    def test_nothing_moves_after_a_motion_fault_that_a_killed_supervisor_did_not_keep(self):
        self.kill_during_a_motion_fault("use_case_supervisor")

    def test_nothing_moves_after_a_motion_fault_that_a_killed_engine_did_not_report(self):
        self.kill_during_a_motion_fault("behavior")

    def kill_during_a_motion_fault(self, node):
        """Kill a node before it learns that an arm has stopped; check that a person is asked."""
        faults, stopped, blocked, begun = [], [], [], []

        def on_goal(_):
            """Stop the node before the operation ends."""
            if faults and not stopped:
                stopped.append(os.kill(victim, signal.SIGSTOP))

        goals = [
            rospy.Subscriber(
                f"remodel_abilities/{ability.lower()}/goal", rospy.AnyMsg, begun.append
            )
            for ability in read_abilities()
        ]
        lay = "remodel_abilities/laywire"
        layings = rospy.Subscriber(f"{lay}/goal", LayWireActionGoal, on_goal)
        results = rospy.Subscriber(f"{lay}/result", LayWireActionResult, blocked.append)
        run = self.orders.start(2)
        victim = self.orders.pid(node)
        self.assertTrue(victim, f"{node} runs")
        self.inject("motion_blocked")
        faults.append("motion_blocked")
        wait_until(lambda: stopped and blocked, "the arm is stopped")
        self.assertEqual(blocked[-1].result.error_code, ErrorCode.MOTION_FAULT)
        before = len(begun)
        os.kill(victim, signal.SIGKILL)
        wait_until(lambda: self.orders.pid(node) not in (0, victim), f"{node} respawns")
        question = self.asked()
        self.assertEqual(len(begun), before, "nothing begins before the answer")
        self.assertIn("Motion blocked", question.text)
        self.answer(question, OperatorQuestion.STOP)
        self.orders.wait_for_end(run)
        self.assertIn("had ended", self.planner("explain", str(run)).stdout)
        for subscriber in (*goals, results, layings):
            subscriber.unregister()


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_supervision_faults", SupervisionFaultsTest)
