#!/usr/bin/env python3
"""An order in one process ends as it does over ROS: its wires lie in the same place to the bit."""

import json
import shutil
import subprocess
import sys
import unittest
from hashlib import sha256
from pathlib import Path

import numpy as np
import rospy
import rostest

DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
LIMIT_S = 1200
SEED = 7  # of the cell in the .test file
WIRES = 2


class RehearsalTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        rospy.init_node("test_rehearsal")

    def test_wires_lie_where_they_were_rehearsed(self):
        self.remodel("import", DESIGN, "--order", "house")
        self.remodel("run", "house", "--wires", str(WIRES), "--output", str(OUTPUT))
        parked = json.loads((OUTPUT / "cell" / "wires.json").read_text())["parked"]
        self.assertEqual(len(parked), WIRES)
        lies = sha256()
        for name, wire in sorted(parked.items()):
            lies.update(name.encode() + np.array(wire["nodes"]).tobytes())
        printed = self.remodel("rehearse", "house", "--wires", str(WIRES), "--seed", str(SEED))
        self.assertIn(f"board {lies.hexdigest()[:16]}", printed)

    def remodel(self, *words):
        """Run a command, and return what it prints."""
        words = ["remodel", *words, "--database", DATABASE]
        done = subprocess.run(
            words, capture_output=True, text=True, timeout=LIMIT_S, check=False, cwd=OUTPUT
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_rehearsal", RehearsalTest)
