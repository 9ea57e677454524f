#!/usr/bin/env python3
"""A use case of a user's own carries its order out over a fake cell, also across a restart."""

import json
import signal
import subprocess

import rosbag
import rostest
from order_client import LIMIT_S, SUPERVISOR, OrderClient, wait_until
from use_cases_case import DATABASE, OUTPUT, UseCasesCase

# rosbag keeps the names as the launch file has them, without the namespace.
RECORDS = "remodel/ability_records"
GOALS = "remodel_abilities/{}/goal"


class UseCasesTest(UseCasesCase):
    def test_a_use_case_of_the_users_own_runs_and_a_resumed_run_keeps_it(self):
        self.add_order("own")
        orders = OrderClient(OUTPUT)
        words = ["remodel", *self.line("own", "own_cabinet", 9)]
        with subprocess.Popen(
            [*words, "--database", DATABASE], stdout=subprocess.PIPE, text=True
        ) as run:
            self.addCleanup(run.kill)
            wait_until(
                lambda: orders.state.order == "own" and orders.state.sums.done, "a task is done"
            )
            orders.end_process(SUPERVISOR)
            printed, _ = run.communicate(timeout=LIMIT_S)
        self.assertEqual(run.returncode, 0, printed)
        self.assertGreaterEqual(orders.state.interruptions, 1)
        self.assertEqual(orders.state.use_case, "own_cabinet")
        report = json.loads((OUTPUT / "own" / "report.json").read_text())
        behaviors = [wire["behavior"] for wire in report["wires"]]
        self.assertEqual([b for b in behaviors if not b.startswith("Hang Wire ")], [])
        self.has_a_bag(orders)

    def has_a_bag(self, orders):
        """Check that the recorder, once it ends, leaves a bag of the run."""
        orders.end_process("bag", signal.SIGINT)
        (file,) = (OUTPUT / "bags").glob("run_*.bag")
        with rosbag.Bag(str(file)) as bag:
            counts = {name: t.message_count for name, t in bag.get_type_and_topic_info()[1].items()}
            records = [message.ability for _, message, _ in bag.read_messages(RECORDS)]
        # A first goal may be sent before the recorder is connected to its sender.
        self.assertIn("InsertCable", records)
        self.assertGreater(counts.get(GOALS.format("insertcable"), 0), 0)
        self.assertGreater(counts["remodel/use_case/state"], 1)
        self.assertIn("flexbe/log", counts)


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_use_cases", UseCasesTest)
