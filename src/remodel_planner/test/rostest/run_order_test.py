#!/usr/bin/env python3
"""The first wire of a real design, from its file to its place in the cell."""

import json
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

import rostest
from lxml import html

from remodel_planner.edge.production_database import ProductionDatabase

DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"


def planner(*line):
    """Run a command of the planner to its end."""
    line = ["rosrun", "remodel_planner", *line, "--database", DATABASE]
    return subprocess.run(line, capture_output=True, text=True, timeout=240, check=False)


class RunOrderTest(unittest.TestCase):
    def setUp(self):
        OUTPUT.mkdir(exist_ok=True)
        self.addCleanup(shutil.rmtree, OUTPUT)

    def test_a_wire_is_imported_planned_synthesized_placed_and_reported(self):
        imported = planner("import", DESIGN, "--order", "house")
        self.assertEqual(imported.returncode, 0, imported.stderr)
        done = planner("run_order", "house", "--wires", "1", "--output", str(OUTPUT))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("1 of 1 wires placed", done.stdout)
        report = json.loads((OUTPUT / "report.json").read_text())
        self.assertTrue(report["complete"])
        abilities = [operation["ability"] for operation in report["wires"][0]["operations"]]
        self.assertEqual(abilities[0], "DetectCable")
        self.assertEqual(abilities[-1], "FixCable")
        page = html.fromstring((OUTPUT / "report.html").read_text())
        self.assertGreaterEqual(len(page.xpath("//img[starts-with(@src, 'data:image/jpeg')]")), 4)
        self.assertEqual(len(page.xpath("//svg")), 3)  # the task, and Place Connector for each end
        ProductionDatabase(DATABASE).order("house")


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_run_order", RunOrderTest)
