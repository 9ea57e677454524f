#!/usr/bin/env python3
"""A wire of a real design, from its file to its place in the cell, which dies meanwhile."""

import json
import shutil
import subprocess
import sys
import threading
import unittest
from pathlib import Path

import rospy
import rostest
from lxml import html
from remodel_msgs.msg import InsertCableActionFeedback
from remodel_msgs.srv import GetGroundTruth, InjectFault

from remodel_production.edge.database.production_database import ProductionDatabase

DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
LIMIT_S = 1200
# The first wire that is not by hand.
BY_ROBOTS = "W3"
DESIGNS = Path(__file__).parents[3] / "remodel_production/test/unit/designs"
# Shipped use cases that this cell does not run, each with a design and what stands in its way.
REFUSED = {
    "automotive_formboard": (DESIGNS / "loom.kbl", "no task is for the robot: all 2 are by hand"),
    "medical_hoses": (DESIGNS / "harness.yml", "no task is for the robot: all 9 are by hand"),
    "branched_harness": (DESIGNS / "loom.kbl", "are no wires of the design; run it by a use case"),
}


def line(*words):
    """Return the words of a command of the planner."""
    return ["remodel", *words, "--database", DATABASE]


class RunOrderTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        rospy.init_node("test_run_order")

    def test_orders_with_nothing_for_the_cell_are_refused_with_the_reasons(self):
        for name, (design, reason) in REFUSED.items():
            subprocess.run(
                line("import", str(design), "--order", name), check=True, timeout=LIMIT_S
            )
            words = line("run", name, "--use-case", name, "--wait", str(LIMIT_S))
            run = subprocess.run(
                words, capture_output=True, text=True, timeout=LIMIT_S, check=False, cwd=OUTPUT
            )
            self.assertEqual(run.returncode, 3, run.stdout + run.stderr)
            self.assertRegex(run.stderr, reason)
        wires = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)().wires
        self.assertEqual(wires, [], "nothing was built")

    def test_wires_are_imported_planned_synthesized_placed_and_reported(self):
        subprocess.run(line("import", DESIGN, "--order", "house"), check=True, timeout=LIMIT_S)
        words = line("run", "house", "--wires", "1", "--output", str(OUTPUT))
        inserting = threading.Event()
        rospy.Subscriber(
            "remodel_abilities/insertcable/feedback",
            InsertCableActionFeedback,
            lambda _: inserting.set(),
        )
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as run:
            self.addCleanup(run.kill)
            self.assertTrue(inserting.wait(LIMIT_S))
            killed = rospy.ServiceProxy("cell/inject_fault", InjectFault)("server_killed", "", [])
            self.assertTrue(killed.success, killed.message)
            printed, _ = run.communicate(timeout=LIMIT_S)
        self.assertEqual(run.returncode, 0, printed)
        self.assertIn("1 of 1 wire placed", printed)
        self.assertIn("net list: 1 of 1 wire as designed\n", printed)
        self.assertIn("by hand: 6 wires, listed in the report\n", printed)
        self.assertIn(" seated by the first insertion; ", printed)
        self.assertIn(" s simulated in ", printed)
        wires = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)().wires
        self.assertEqual([(wire.wire_id, wire.placed) for wire in wires], [(BY_ROBOTS, True)])
        self.check_report()
        ProductionDatabase(DATABASE).order("house")

    def check_what_was_built(self, report):
        self.assertEqual(report["unread"], "")
        (net,) = [net for net in report["net_list"] if net["wire"] == BY_ROBOTS]
        self.assertEqual(sorted(net["cell"]), sorted(net["design"]))
        self.assertEqual((net["verdict"], net["fixed"]), ("as designed", [True, True]))
        self.assertGreater(net["duct_length_m"], 0.0)
        self.assertGreater(report["simulated_s"], report["cell_s"])
        self.assertAlmostEqual(
            report["real_time_factor"], report["simulated_s"] / report["wall_s"], delta=0.02
        )

    def check_report(self):
        report = json.loads((OUTPUT / "report.json").read_text())
        self.assertTrue(report["complete"])
        self.check_what_was_built(report)
        last = report["wires"][-1]
        abilities = [operation["ability"] for operation in last["operations"]]
        self.assertEqual(abilities[0], "DetectCable")
        self.assertEqual(abilities[-1], "FixCable")
        page = html.fromstring((OUTPUT / "report.html").read_text())
        built = page.xpath("//h2[@id='built']/following-sibling::*")
        self.assertTrue(any(part.xpath(".//img[starts-with(@src, 'data:')]") for part in built))
        text = " ".join(part.text_content() for part in built)
        self.assertIn("equal to the design's: 1 of 1 wires", text)
        pictures = page.xpath("//img[starts-with(@src, 'data:image/jpeg')]")
        self.assertGreaterEqual(len(pictures), 4)
        self.assertTrue(page.xpath("//svg"))


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_run_order", RunOrderTest)
