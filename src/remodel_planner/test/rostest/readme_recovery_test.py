#!/usr/bin/env python3
"""The commands of the README's recovery example recover, and print what the README says."""

import re
import subprocess
import unittest
from pathlib import Path

import rospy
import rostest

README = Path(__file__).parents[4] / "README.md"
LIMIT_S = 300


def recovery_commands():
    """Return the README's block of commands that injects a fault."""
    blocks = re.findall(r"^```sh\n(.*?)^```$", README.read_text(), re.MULTILINE | re.DOTALL)
    (found,) = [block for block in blocks if "inject_fault" in block]
    return found


class ReadmeRecoveryTest(unittest.TestCase):
    def test_the_second_observation_heals_the_fault(self):
        rospy.wait_for_service("cell/reset", 60.0)
        line = ["bash", "-c", recovery_commands()]
        ran = subprocess.run(line, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        printed = ran.stdout + ran.stderr
        self.assertEqual(ran.returncode, 0, printed)
        self.assertIn("ended with outcome 'finished'", printed)
        self.assertIn("InsertCable failed: error 300: ", printed)
        self.assertIn("the tip sits on the face of 'X1/1'", printed)
        steps = re.findall(r"^be_launcher: InsertCable \d+ %: (.+)$", printed, re.MULTILINE)
        self.assertGreater(len(set(steps)), 1, printed)
        states = re.findall(r"is at /(\w+)$", printed, re.MULTILINE)
        visited = [state for state in states if "_" not in state]
        first = ["LocateGearboxComponent", "InsertCable", "ExtractCable"]
        self.assertEqual(visited, [*first, "LocateGearboxComponent", "InsertCable", "FixCable"])


if __name__ == "__main__":
    rospy.init_node("test_readme_recovery")
    rostest.rosrun("remodel_planner", "test_readme_recovery", ReadmeRecoveryTest)
