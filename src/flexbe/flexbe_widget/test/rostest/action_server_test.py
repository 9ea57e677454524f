#!/usr/bin/env python3
"""Behaviors as an action: how goals end, whatever happens."""

import contextlib
import os
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import rosgraph
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorExecutionAction,
    BehaviorExecutionGoal,
    BEStatus,
    CommandFeedback,
)
from std_msgs.msg import String, UInt8

from flexbe_core.testing import wait_until
from flexbe_widget.core.run_watch import ENGINE_LOST_TEXT, FAILED_TEXT, NOT_STARTED_TEXT

LIMIT_S = 90.0


class ActionServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.statuses = []
        rospy.Subscriber("flexbe/status", BEStatus, cls.statuses.append)
        cls.client = cls.connect("flexbe/execute_behavior")

    @staticmethod
    def connect(name):
        client = actionlib.ActionClient(name, BehaviorExecutionAction)
        assert client.wait_for_server(rospy.Duration(LIMIT_S))
        return client

    def setUp(self):
        self.statuses.clear()
        self.feedback = []

    def send(self, name, client=None, **parameters):
        goal = BehaviorExecutionGoal(
            behavior_name=name, arg_keys=list(parameters), arg_values=list(parameters.values())
        )
        return (client or self.client).send_goal(goal, feedback_cb=self.on_feedback)

    def on_feedback(self, handle, feedback):
        self.feedback.append(feedback.current_state)

    def is_running(self):
        return any(status.code == BEStatus.STARTED for status in self.statuses)

    def outcomes(self):
        return [status.args for status in self.statuses if status.code == BEStatus.FINISHED]

    def assert_ends(self, handle, status, outcome="", limit_s=LIMIT_S):
        done = actionlib.CommState.DONE
        self.assertTrue(wait_until(lambda: handle.get_comm_state() == done, limit_s), "never ends")
        self.assertEqual(
            (handle.get_goal_status(), handle.get_result().outcome),
            (status, outcome),
            handle.get_goal_status_text(),
        )
        return handle.get_goal_status_text()

    def test_a_behavior_succeeds_with_its_outcome_and_reports_its_states(self):
        handle = self.send("Quick Test")
        self.assert_ends(handle, GoalStatus.SUCCEEDED, "finished")
        self.assertEqual(self.feedback[:2], ["/Say", "/Wait"])

    def test_a_goal_cancelled_at_once_is_preempted(self):
        handle = self.send("Quick Test", wait_time="60")
        self.assertTrue(wait_until(lambda: handle.get_goal_status() == GoalStatus.ACTIVE))
        handle.cancel()
        self.assert_ends(handle, GoalStatus.PREEMPTED, "preempted")

    def test_an_unknown_behavior_is_rejected_with_near_names(self):
        text = self.assert_ends(self.send("Quick Tset"), GoalStatus.REJECTED)
        self.assertIn("unknown behavior 'Quick Tset'; near it: 'Quick Test'", text)

    def test_a_failing_behavior_is_aborted_with_the_reason(self):
        text = self.assert_ends(self.send("Faulty Test"), GoalStatus.ABORTED)
        self.assertTrue(text.startswith(f"{FAILED_TEXT}'Faulty Test': "), text)
        self.assertIn("/Faulty: RuntimeError: no camera image", text)

    def test_a_refused_behavior_is_aborted_with_the_reason(self):
        text = self.assert_ends(self.send("Quick Test", wait_time="soon"), GoalStatus.ABORTED)
        self.assertTrue(text.startswith(f"{NOT_STARTED_TEXT}'Quick Test': "), text)
        self.assertIn("takes a value of type float, found 'soon'", text)

    def test_a_new_goal_stops_the_running_one_and_follows_it(self):
        first = self.send("Quick Test", wait_time="60")
        self.assertTrue(wait_until(self.is_running))
        second = self.send("Quick Test", wait_time="0")
        self.assert_ends(first, GoalStatus.PREEMPTED, "preempted")
        self.assert_ends(second, GoalStatus.SUCCEEDED, "finished")

    def test_values_come_from_files(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "values.yaml"
            file.write_text("times: {short: 0}\n")
            handle = self.send("Quick Test", wait_time=f"file://{file}:times/short")
            self.assert_ends(handle, GoalStatus.SUCCEEDED, "finished")
            handle = self.send("Quick Test", wait_time=f"file://{file}:times/long")
            text = self.assert_ends(handle, GoalStatus.REJECTED)
            self.assertIn("has no entry 'times/long'; at 'long' there are: short", text)

    def test_a_killed_engine_aborts_the_goal(self):
        self.check_engine_ended_by(signal.SIGKILL)

    def test_an_engine_that_is_terminated_has_not_been_asked_to_stop_the_behavior(self):
        self.check_engine_ended_by(signal.SIGTERM)

    def check_engine_ended_by(self, number):
        handle = self.send("Quick Test", wait_time="60")
        self.assertTrue(wait_until(self.is_running))
        os.kill(pid_of("/behavior"), number)
        text = self.assert_ends(handle, GoalStatus.ABORTED)
        self.assertTrue(text.startswith(ENGINE_LOST_TEXT), text)
        self.assertTrue(wait_until(lambda: self.statuses[-1].code == BEStatus.READY))
        self.assert_ends(self.send("Quick Test"), GoalStatus.SUCCEEDED, "finished")

    @contextlib.contextmanager
    def stopped_engine(self):
        """Stop the engine's process, as a debugger or a machine that swaps does."""
        engine = pid_of("/behavior")
        os.kill(engine, signal.SIGSTOP)
        try:
            yield
        finally:
            os.kill(engine, signal.SIGCONT)

    def assert_lost(self, handle):
        text = self.assert_ends(handle, GoalStatus.ABORTED)
        self.assertTrue(text.startswith(ENGINE_LOST_TEXT), text)

    def assert_stopped(self):
        """The behavior that was given up is stopped once the engine is back."""
        self.assertTrue(wait_until(lambda: any(s.args == ["preempted"] for s in self.statuses)))

    def test_the_next_goal_waits_until_a_stalled_engine_has_stopped_the_last(self):
        handle = self.send("Quick Test", wait_time="60")
        self.assertTrue(wait_until(self.is_running))
        with self.stopped_engine():
            self.assert_lost(handle)
            following = self.send("Quick Test", text="next")
            accepted = wait_until(lambda: following.get_goal_status() == GoalStatus.ACTIVE)
            self.assertTrue(accepted)
        self.assert_ends(following, GoalStatus.SUCCEEDED, "finished")
        # The answer to the goal may be here before the last status.
        wait_until(lambda: len(self.outcomes()) == 2)
        self.assertEqual(self.outcomes(), [["preempted"], ["finished"]])

    def test_a_behavior_that_a_stalled_engine_has_not_begun_is_stopped_once_it_begins(self):
        with self.stopped_engine():
            self.assert_lost(self.send("Quick Test", wait_time="60"))
        self.assert_stopped()

    def test_an_operator_may_join_with_the_line_of_the_deliverable(self):
        handle = self.send("Quick Test", wait_time="60")
        self.assertTrue(wait_until(self.is_running))
        attach = rospy.Publisher("flexbe/command/attach", UInt8, queue_size=1)
        answers, paths = [], []
        rospy.Subscriber("flexbe/command_feedback", CommandFeedback, answers.append)
        rospy.Subscriber("flexbe/behavior_update", String, lambda m: paths.append(m.data))
        line = ["roslaunch", "flexbe_widget", "behavior_ocs.launch"]
        ocs = subprocess.Popen(line, stdout=subprocess.DEVNULL)
        try:
            self.assertTrue(wait_until(lambda: "/Wait" in paths), "the mirror shows nothing")
            attach.publish(3)
            self.assertTrue(wait_until(lambda: any(a.command == "attach" for a in answers)))
            (answer,) = [a.args for a in answers if a.command == "attach"]
            self.assertEqual(answer, ["Quick Test"])
            handle.cancel()
            self.assert_ends(handle, GoalStatus.PREEMPTED, "preempted")
            self.assertTrue(wait_until(lambda: paths[-1] == ""))
        finally:
            ocs.send_signal(signal.SIGINT)
            ocs.wait(LIMIT_S)

    def test_without_an_engine_a_goal_is_aborted(self):
        alone = self.connect("alone/flexbe/execute_behavior")
        text = self.assert_ends(self.send("Quick Test", alone), GoalStatus.ABORTED)
        self.assertTrue(text.startswith(ENGINE_LOST_TEXT), text)
        self.assertIn("roslaunch flexbe_onboard behavior_onboard.launch", text)

    def test_the_line_of_the_deliverable_works(self):
        line = (
            "rostopic pub -1 /flexbe/execute_behavior/goal "
            "flexbe_msgs/BehaviorExecutionActionGoal "
            "'{goal: {behavior_name: \"Quick Test\"}}'"
        )
        subprocess.run(line, shell=True, check=True, stdout=subprocess.DEVNULL, timeout=LIMIT_S)
        self.assertTrue(wait_until(lambda: any(s.args == ["finished"] for s in self.statuses)))


def pid_of(node):
    """Return the process of a node, which it reports itself."""
    uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
    return ServerProxy(uri).getPid(rospy.get_name())[2]


if __name__ == "__main__":
    rospy.init_node("test_action_server")
    rostest.rosrun("flexbe_widget", "test_action_server", ActionServerTest)
