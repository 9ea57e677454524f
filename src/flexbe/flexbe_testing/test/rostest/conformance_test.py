#!/usr/bin/env python3
"""This workspace's engine keeps everything that engine_conformance judges."""

import json
import signal
import subprocess
import unittest

import rospy
import rostest
from flexbe_msgs.msg import BehaviorSelection, BEStatus

# Judged in the namespace `whole`, which has a mirror and an action server.
WHOLE = (
    *("mirror-publishes-paths", "action-succeeds", "action-unknown-behavior"),
    *("action-is-cancelled", "action-is-aborted", "attach", "sync", "preempt-supervised"),
)


def run_kit(*words):
    """Return the exit code, and the verdict and reason of each scenario."""
    command = ["rosrun", "flexbe_testing", "engine_conformance", "--json", "--quiet", "0.2"]
    command += ["--limit", "60", *words]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, timeout=400)
    rows = json.loads(done.stdout)
    return done.returncode, {row["scenario"]: (row["verdict"], row["reason"]) for row in rows}


class ConformanceTest(unittest.TestCase):
    def test_an_engine_alone(self):
        code, found = run_kit("__ns:=/alone")
        missing = {name: why for name, (verdict, why) in found.items() if verdict != "pass"}
        expected = {name for name in WHOLE if name.startswith(("mirror-", "action-"))}
        self.assertEqual(set(missing), expected, missing)
        self.assertEqual(code, 0)
        self.assertIn("there is no mirror", found["mirror-publishes-paths"][1])
        self.assertIn("there is no action server", found["action-succeeds"][1])

    def test_an_engine_with_mirror_and_action_server(self):
        code, found = run_kit("__ns:=/whole", *(f"--only={name}" for name in WHOLE))
        missing = {name: why for name, (verdict, why) in found.items() if verdict != "pass"}
        self.assertEqual(missing, {})
        self.assertEqual((code, len(found)), (0, len(WHOLE) + 1))

    def test_an_interrupt_leaves_the_engine_idle(self):
        command = ["rosrun", "flexbe_testing", "engine_conformance", "__ns:=/whole"]
        running = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # A shell starts what runs in its background with SIGINT ignored.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        self.assertIn("runs-behaviors", running.stdout.readline())
        rospy.wait_for_message("/whole/flexbe/start_behavior", BehaviorSelection, 90.0)
        running.send_signal(signal.SIGINT)
        _, errors = running.communicate(timeout=90)
        self.assertEqual(errors, "")
        self.assertEqual(running.returncode, 130)
        last = rospy.wait_for_message("/whole/flexbe/status", BEStatus, 60.0)
        self.assertNotEqual(last.code, BEStatus.STARTED)


if __name__ == "__main__":
    rospy.init_node("test_conformance")
    rostest.rosrun("flexbe_testing", "test_conformance", ConformanceTest)
