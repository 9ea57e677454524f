#!/usr/bin/env python3
"""Shipped use cases, and one of a user's own, carry their orders out over a fake cell."""

import json
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

import rospy
import rostest
import yaml
from order_client import DESIGN, LIMIT_S, SUPERVISOR, OrderClient, planner, wait_until

from remodel_planning.edge.use_case_files import use_case_folder
from remodel_supervision.core.runs.events import Ending

OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
DESIGNS = Path(__file__).parents[3] / "remodel_production/test/unit/designs"
HARNESS = Path(__file__).parents[3] / "remodel_planning/examples/harness.yml"

# A design for each shipped use case, how many of its wires are asked for, and how many of these
# are placed: the others are by hand.
SHIPPED = {
    "cabinet": (DESIGN, 6, 3),
    "harness_formboard": (HARNESS, 3, 3),
    "automotive_formboard": (DESIGNS / "loom.kbl", 2, 2),
    "medical_hoses": (DESIGNS / "harness.yml", 3, 3),
}


def far(own):
    """Have a use case name a robot that the cell does not have."""
    own.update(yaml.safe_load(yaml.safe_dump(own).replace("robot_2", "robot_8")))


class UseCasesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_use_cases")
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        # A user's own: a folder outside the workspace, which REMODEL_USE_CASES names.
        (OUTPUT / "use_cases").mkdir(parents=True)
        cls.add_own("own_cabinet", lambda own: own.update(title="Hang Wire {task}"))

    @staticmethod
    def add_own(name, change):
        own = yaml.safe_load((use_case_folder() / "cabinet.yaml").read_text())
        del own["designs"]["default_for"]
        own["name"] = name
        change(own)
        (OUTPUT / f"use_cases/{name}.yaml").write_text(yaml.safe_dump(own))

    def add_order(self, name, design=DESIGN):
        imported = planner("import", str(design), "--order", name, database=DATABASE)
        self.assertEqual(imported.returncode, 0, imported.stderr)

    def line(self, order, use_case, tasks):
        options = ("--use-case", use_case, "--wires", str(tasks), "--output", str(OUTPUT / order))
        return ("run_order", order, *options)

    def test_each_shipped_use_case_is_tried(self):
        shipped = {file.stem for file in use_case_folder().glob("*.yaml")}
        self.assertEqual(shipped, {*SHIPPED, "branched_harness"})

    def carries_its_order_out(self, name):
        design, wires, tasks = SHIPPED[name]
        self.add_order(name, design)
        ran = planner(*self.line(name, name, wires), database=DATABASE)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn(f"order {name}, use case {name}, ", ran.stdout)
        whole = f"{tasks} of {tasks} wires placed, {tasks} without a failed operation"
        self.assertIn(whole, ran.stdout)

    def test_cabinet_carries_its_order_out(self):
        self.carries_its_order_out("cabinet")

    def test_harness_formboard_carries_its_order_out(self):
        self.carries_its_order_out("harness_formboard")

    def places_a_new_wire(self, order, **fault):
        """Have a fault strike one piece of a wire of an order; return what is printed."""
        self.add_order(order)
        rospy.set_param("fake_cell/faults", [{"cure": "new_part", **fault}])
        self.addCleanup(rospy.delete_param, "fake_cell/faults")
        ran = planner(*self.line(order, "cabinet", 5), database=DATABASE)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn("2 of 2 wires placed, 1 without a failed operation", ran.stdout)
        self.assertIn("  discarded, 0 insertions, ", ran.stdout)
        self.assertIn(">discarded<", (OUTPUT / f"{order}/report.html").read_text())
        return ran.stdout

    def test_two_robots_release_discard_and_begin_again_with_a_new_wire(self):
        self.places_a_new_wire("slipping", name="slipped")
        orders = OrderClient(OUTPUT)
        self.assertEqual(orders.held, "")
        self.assertEqual(len(orders.account(orders.runs()[0]).fed_again), 1)

    def test_a_wire_that_left_its_ducts_once_both_ends_are_fixed_is_discarded(self):
        fault = {"name": "out_of_duct", "ability": "FixCable", "nth": 2}
        printed = self.places_a_new_wire("lifted", **fault)
        self.assertIn("FixCable, error 310: ", printed)
        self.assertIn("; 1 failed operation; ", printed, "the end is not pushed in again")

    def test_a_wire_whose_first_end_came_out_is_discarded(self):
        fault = {"name": "came_out", "ability": "FixCable", "nth": 2}
        printed = self.places_a_new_wire("drawn", **fault)
        self.assertIn("FixCable, error 311: ", printed)
        self.assertIn("; 1 failed operation; ", printed, "no end is pushed in again")

    def test_automotive_formboard_carries_its_order_out(self):
        self.carries_its_order_out("automotive_formboard")

    def test_medical_hoses_carries_its_order_out(self):
        self.carries_its_order_out("medical_hoses")

    def test_an_order_of_branches_is_refused_with_the_reason(self):
        self.add_order("loom", DESIGNS / "loom.kbl")
        ran = planner(*self.line("loom", "branched_harness", 2), database=DATABASE)
        self.assertEqual(ran.returncode, 3, ran.stdout + ran.stderr)
        self.assertIn("are no wires of the design; run it by a use case of wires", ran.stderr)

    def test_an_order_that_the_cell_refuses_leaves_its_panel_alone_and_can_be_run_later(self):
        self.add_own("far", far)
        for name in ("first", "second"):
            self.add_order(name)
        done = planner(*self.line("first", "cabinet", 2), database=DATABASE)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        orders = OrderClient(OUTPUT)
        before = orders.world.read().world
        refused = planner(*self.line("second", "far", 5), database=DATABASE)
        self.assertEqual(refused.returncode, 3, refused.stdout + refused.stderr)
        self.assertIn("name robot 'robot_8'; the cell has robot_1, robot_2", refused.stderr)
        self.assertIn("Nothing has moved. Correct the design or use case far", refused.stderr)
        self.assertEqual(orders.world.read().world, before)
        self.assertEqual(orders.run_state(orders.runs()[0]).ended.ending, Ending.STOPPED)
        later = planner(*self.line("second", "cabinet", 5), database=DATABASE)
        self.assertEqual(later.returncode, 0, later.stdout + later.stderr)
        self.assertIn("product second-0001: 2 tasks", later.stdout)
        self.assertIn("2 without a failed operation", later.stdout)

    def test_a_use_case_of_the_users_own_runs_and_a_resumed_run_keeps_it(self):
        self.add_order("own")
        orders = OrderClient(OUTPUT)
        words = ["rosrun", "remodel_planner", "planner", *self.line("own", "own_cabinet", 9)]
        with subprocess.Popen(
            [*words, "--database", DATABASE], stdout=subprocess.PIPE, text=True
        ) as run:
            self.addCleanup(run.kill)
            wait_until(lambda: orders.state.order == "own" and orders.state.done, "a task is done")
            orders.end_process(SUPERVISOR)
            printed, _ = run.communicate(timeout=LIMIT_S)
        self.assertEqual(run.returncode, 0, printed)
        self.assertGreaterEqual(orders.state.interruptions, 1)
        self.assertEqual(orders.state.use_case, "own_cabinet")
        report = json.loads((OUTPUT / "own" / "report.json").read_text())
        behaviors = [wire["behavior"] for wire in report["wires"]]
        self.assertEqual([b for b in behaviors if not b.startswith("Hang Wire ")], [])

    def test_the_error_about_an_unknown_name_lists_what_there_is_and_where_it_was_searched(self):
        self.add_order("unknown")
        ran = planner(*self.line("unknown", "cabinett", 2), database=DATABASE)
        self.assertEqual(ran.returncode, 3, ran.stdout)
        self.assertIn("no use case cabinett; there are automotive_formboard, ", ran.stderr)
        self.assertIn("own_cabinet", ran.stderr)
        self.assertIn(f"(searched: {OUTPUT / 'use_cases'}, {use_case_folder()})", ran.stderr)


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_use_cases", UseCasesTest)
