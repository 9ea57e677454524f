#!/usr/bin/env python3
"""Shipped use cases, and one of a user's own, carry their orders out over a fake cell."""

import json
import subprocess

import rostest
from order_client import LIMIT_S, SUPERVISOR, OrderClient, planner, wait_until
from use_cases_case import DATABASE, DESIGNS, OUTPUT, SHIPPED, UseCasesCase

from remodel_planning.edge.use_case_files import use_case_folder


class UseCasesTest(UseCasesCase):
    def test_each_shipped_use_case_is_tried(self):
        shipped = {file.stem for file in use_case_folder().glob("*.yaml")}
        self.assertEqual(shipped, {*SHIPPED, "branched_harness"})

    def test_cabinet_carries_its_order_out(self):
        self.carries_its_order_out("cabinet")

    def test_an_order_of_branches_is_refused_with_the_reason(self):
        self.add_order("loom", DESIGNS / "loom.kbl")
        ran = planner(*self.line("loom", "branched_harness", 2), database=DATABASE)
        self.assertEqual(ran.returncode, 3, ran.stdout + ran.stderr)
        self.assertIn("are no wires of the design; run it by a use case of wires", ran.stderr)

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
