#!/usr/bin/env python3
"""Cases with a behavior, with launched nodes and with a bag, and the exit code of the node."""

import subprocess
import tempfile
import unittest
from pathlib import Path

import rosbag
import rospy
import rostest
from std_msgs.msg import String

PUBLISHER = (
    '<launch><node name="publisher" pkg="rostopic" type="rostopic" '
    'args="pub -l /testing/text std_msgs/String launched"/></launch>'
)


class TestingTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def run_case(self, text):
        """Return the exit code of the testing node and what it printed."""
        file = Path(self.folder.name) / "case.test"
        file.write_text(text)
        done = subprocess.run(
            ["rosrun", "flexbe_testing", "testing_node", str(file)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120,
        )
        return done.returncode, done.stdout

    def test_a_behavior_runs_with_its_parameters(self):
        code, printed = self.run_case(
            "{path: engine_test_behaviors.input_sm, class: InputSM, outcome: finished,\n"
            " params: {wait_time: 0.1}, input: {part: {pins: [1]}}, output: {part: {pins: [1]}}}"
        )
        self.assertEqual(code, 0, printed)

    def test_a_failure_is_reported_and_has_an_exit_code(self):
        code, printed = self.run_case(
            "{path: flexbe_states.wait_state, class: WaitState, params: {wait_time: 0},\n"
            " outcome: failed}"
        )
        self.assertEqual(code, 1)
        self.assertIn("outcome is 'done'; expected was 'failed'", printed)

    def test_nodes_may_run_beside_a_case(self):
        code, printed = self.run_case(
            "path: flexbe_states.subscriber_state\n"
            "class: SubscriberState\n"
            f"launch: '{PUBLISHER}'\n"
            "wait_cond: \"'/testing/text' in dict(rospy.get_published_topics())\"\n"
            "params: {topic: /testing/text}\n"
            "outcome: received\n"
        )
        self.assertEqual(code, 0, printed)

    def test_values_come_out_of_a_bag(self):
        bag = Path(self.folder.name) / "some.bag"
        with rosbag.Bag(str(bag), "w") as file:
            file.write("/said", String("recorded"), rospy.Time(1))
        code, printed = self.run_case(
            f"data: {bag}\n"
            "path: flexbe_states.calculation_state\n"
            "class: CalculationState\n"
            "params: {calculation: 'lambda m: m.data'}\n"
            "input: {input_value: /said}\n"
            "output: {output_value: recorded}\n"
        )
        self.assertEqual(code, 0, printed)


if __name__ == "__main__":
    rospy.init_node("test_testing")
    rostest.rosrun("flexbe_testing", "test_testing", TestingTest)
