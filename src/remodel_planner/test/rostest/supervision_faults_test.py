#!/usr/bin/env python3
"""Nothing moves after a motion fault of which a killed process did not learn."""

import os
import signal

import rospy
import rostest
from remodel_msgs.msg import (
    ErrorCode,
    LayWireActionGoal,
    LayWireActionResult,
    OperatorQuestion,
    UseCaseState,
)
from remodel_msgs.srv import AnswerQuestion, InjectFault
from supervision_case import SupervisionCase, call, planner

from remodel_states.edge.exported_tables import read_abilities


class SupervisionFaultsTest(SupervisionCase):
    def test_nothing_moves_after_a_motion_fault_that_a_killed_supervisor_did_not_keep(self):
        self.kill_during_a_motion_fault("use_case_supervisor")

    def test_nothing_moves_after_a_motion_fault_that_a_killed_engine_did_not_report(self):
        self.kill_during_a_motion_fault("behavior")

    def kill_during_a_motion_fault(self, node):
        """Kill a node before it learns that an arm has stopped; check that a person is asked."""
        rospy.wait_for_service("cell/inject_fault", 180.0)
        victim = self.pid(node)
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
        inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
        self.start(2)
        self.wait(self.task_running, "the panel is loaded, which mends all faults")
        caused = inject(kind="motion_blocked", target="ask_operator", values=[])
        self.assertTrue(caused.success, caused.message)
        faults.append(caused)
        self.wait(lambda: stopped and blocked, "the arm is stopped")
        self.assertEqual(blocked[-1].result.error_code, ErrorCode.MOTION_FAULT)
        before = len(begun)
        os.kill(victim, signal.SIGKILL)
        self.wait(lambda: self.pid(node) not in (0, victim), f"{node} respawns")
        self.wait(lambda: self.last().phase == UseCaseState.ASKING, "the operator is asked")
        self.assertEqual(len(begun), before, "nothing begins before the answer")
        question = self.last().question
        self.assertIn("Motion blocked", question.text)
        given = {"question": question.number, "choice": OperatorQuestion.STOP, "by": "ann"}
        self.assertTrue(call("answer", AnswerQuestion, **given).success)
        self.wait(lambda: self.last().phase == UseCaseState.ENDED, "the run ends")
        self.assertIn("had ended", planner("explain", str(self.last().run)).stdout)
        for subscriber in (*goals, results, layings):
            subscriber.unregister()


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_supervision_faults", SupervisionFaultsTest)
