#!/usr/bin/env python3
"""A run goes on when its processes are killed, asks an operator, and plays back to itself."""

import rostest
from order_client import wait_until
from remodel_msgs.msg import (
    OperatorQuestion,
    TaskState,
    UseCaseState,
)
from remodel_msgs.srv import AnswerQuestion, GetRun, ListRuns
from supervision_case import SupervisionCase, call


class SupervisionTest(SupervisionCase):
    def record_of(self, run):
        """Yield the entries of a run with their pictures, of which an answer holds few."""
        first = 1
        while entries := call("record", GetRun, run=run, first=first, with_pictures=True).entries:
            yield from entries
            first += len(entries)

    def test_killed_processes_come_again_and_nothing_is_lost(self):
        run = self.orders.start(3)
        for node in ("use_case_supervisor", "behavior", "fake_cell"):
            wait_until(lambda: self.orders.state.task, "a task is under way")
            self.orders.end_process(node)
        self.orders.wait_for_end(run)
        states = self.orders.task_states(run)
        self.assertEqual([*states.values()], [TaskState.DONE] * 3)
        self.assertGreaterEqual(self.orders.state.interruptions, 1)
        found = self.orders.account(run)
        self.assertEqual((found.fixed_again, found.omitted), ((), ()))
        played = self.planner("replay", str(run))
        self.assertEqual(played.returncode, 0, played.stdout)
        runs = call("runs", ListRuns).runs
        self.assertEqual((runs[0].run, runs[0].ended, runs[0].sums.done), (run, True, 3))
        self.assertTrue(any(entry.picture.data for entry in self.record_of(run)))

    def test_an_operator_answers_and_stops(self):
        wait_until(lambda: self.orders.is_free, "the supervisor is free")
        handle = self.orders.send(4)
        self.inject("insertion_jammed")
        question = self.asked()
        self.assertIn("Insertion jammed", question.text)
        wrong = call("answer", AnswerQuestion, question=question.number, choice="maybe", by="ann")
        self.assertFalse(wrong.success)
        self.answer(question, OperatorQuestion.SKIP)
        self.orders.wait_for_phase(UseCaseState.RUNNING)
        self.orders.require("stop")
        wait_until(lambda: handle.get_result() is not None, "the goal ends")
        self.assertFalse(handle.get_result().success)
        self.orders.wait_for_phase(UseCaseState.ENDED)
        self.assertIn("the test stopped it", self.orders.state.message)
        printed = self.planner("explain", str(self.orders.state.run))
        self.assertIn("ann: answered: skip", printed.stdout)


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_supervision", SupervisionTest)
