#!/usr/bin/env python3
"""The command lines that Deliverable 5.1 prints, in a shell, as a user types them."""

import os
import signal
import subprocess
import tempfile
import threading
import unittest

import rospy
import rostest
from flexbe_msgs.msg import BehaviorExecutionActionResult, BEStatus

LIMIT_S = 90.0


class Statuses:
    """What the engine says, waited for."""

    def __init__(self):
        self._changed = threading.Condition()
        self._seen = []
        self._subscriber = rospy.Subscriber("flexbe/status", BEStatus, self._on_status)

    def _on_status(self, status):
        with self._changed:
            self._seen.append(status)
            self._changed.notify_all()

    def wait_for(self, code):
        with self._changed:
            found = self._changed.wait_for(
                lambda: [status for status in self._seen if status.code == code], LIMIT_S
            )
            return found[-1] if found else None

    def close(self):
        self._subscriber.unregister()


class CommandLinesTest(unittest.TestCase):
    def setUp(self):
        self.statuses = Statuses()
        self.processes = []

    def tearDown(self):
        self.statuses.close()
        for process in self.processes:
            os.killpg(process.pid, signal.SIGINT)
            process.wait(60)

    def run_line(self, line):
        """Run a line to its end."""
        return subprocess.run(
            ["bash", "-c", line], capture_output=True, text=True, timeout=180, check=False
        )

    def start_line(self, line):
        """Start a line that goes on until the test ends."""
        process = subprocess.Popen(["bash", "-c", f"exec {line}"], start_new_session=True)
        self.processes.append(process)

    def test_be_launcher_runs_a_behavior_whose_name_has_a_blank(self):
        done = self.run_line("rosrun flexbe_widget be_launcher -b 'Example Behavior'")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("finished", done.stdout + done.stderr)

    def test_be_launcher_launch_file(self):
        self.start_line(
            "roslaunch flexbe_widget be_launcher.launch behavior_name:='Example Behavior'"
        )
        status = self.statuses.wait_for(BEStatus.FINISHED)
        self.assertIsNotNone(status)
        self.assertEqual(status.args, ["finished"])

    def test_be_launcher_in_a_launch_file_as_printed(self):
        text = (
            '<launch><arg name="behavior_name" default="Example Behavior" /><node\n'
            'name="behavior_launcher" pkg="flexbe_widget" type="be_launcher" output="screen" '
            "args=\"-b '$(arg behavior_name)'\" /></launch>"
        )
        with tempfile.NamedTemporaryFile("w", suffix=".launch") as file:
            file.write(text)
            file.flush()
            self.start_line(f"roslaunch {file.name}")
            self.assertIsNotNone(self.statuses.wait_for(BEStatus.FINISHED))

    def test_be_action_server_and_the_goal_as_printed(self):
        results = []
        got = threading.Event()
        rospy.Subscriber(
            "/flexbe/execute_behavior/result",
            BehaviorExecutionActionResult,
            lambda message: (results.append(message), got.set()),
        )
        self.start_line("roslaunch flexbe_widget be_action_server.launch")
        self.start_line(
            "rostopic pub /flexbe/execute_behavior/goal flexbe_msgs/BehaviorExecutionActionGoal "
            "'{goal: {behavior_name: \"Example Behavior\"}}'"
        )
        self.assertTrue(got.wait(LIMIT_S))
        self.assertEqual(results[0].result.outcome, "finished")

    def test_both_preempt_topics_stop_a_behavior(self):
        for topic in ("/flexbe/commands/preempt", "/flexbe/command/preempt"):
            statuses = Statuses()
            self.start_line("rosrun flexbe_widget be_launcher -b 'Example Behavior'")
            self.assertIsNotNone(statuses.wait_for(BEStatus.STARTED), topic)
            self.run_line(f"rostopic pub -1 {topic} std_msgs/Empty")
            status = statuses.wait_for(BEStatus.FINISHED)
            statuses.close()
            self.assertEqual(status.args, ["preempted"], topic)

    def test_an_unknown_behavior_is_refused_with_near_names(self):
        done = self.run_line("rosrun flexbe_widget be_launcher -b 'Exmaple Behavior'")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("Example Behavior", done.stdout + done.stderr)


if __name__ == "__main__":
    rospy.init_node("test_command_lines")
    rostest.rosrun("remodel_behaviors", "test_command_lines", CommandLinesTest)
