#!/usr/bin/env python3
"""A run goes on when its processes are killed, asks an operator, and plays back to itself."""

import rospy
import rostest
from remodel_msgs.msg import (
    OperatorQuestion,
    TaskState,
    UseCaseState,
)
from remodel_msgs.srv import AnswerQuestion, CommandRun, GetRun, GetTasks, InjectFault, ListRuns
from supervision_case import OUTPUT, SupervisionCase, call, planner

from remodel_states.testing.world import account
from remodel_states.testing.world_file import WorldFile


class SupervisionTest(SupervisionCase):
    def record_of(self, run):
        """Yield the entries of a run with their pictures, of which an answer holds few."""
        first = 1
        while entries := call("record", GetRun, run=run, first=first, with_pictures=True).entries:
            yield from entries
            first += len(entries)

    def test_killed_processes_come_again_and_nothing_is_lost(self):
        self.start(3)
        for node in ("use_case_supervisor", "behavior", "fake_cell"):
            self.wait(self.task_running, "a task is under way")
            self.kill(node)
        self.wait(lambda: self.last().phase == UseCaseState.ENDED, "the run ends")
        state = self.last()
        tasks = call("tasks", GetTasks, run=state.run).tasks
        self.assertEqual([task.state for task in tasks], [TaskState.DONE] * 3)
        self.assertGreaterEqual(state.interruptions, 1)
        names = [task.name for task in tasks]
        found = account(WorldFile(OUTPUT / "world.sqlite").ledger(), names)
        self.assertEqual((found.fixed_again, found.omitted), ((), ()))
        played = planner("replay", str(state.run))
        self.assertEqual(played.returncode, 0, played.stdout)
        runs = call("runs", ListRuns).runs
        self.assertEqual((runs[0].run, runs[0].ended, runs[0].sums.done), (state.run, True, 3))
        self.assertTrue(any(entry.picture.data for entry in self.record_of(state.run)))

    def test_an_operator_answers_and_stops(self):
        rospy.wait_for_service("cell/inject_fault", 180.0)
        handle = self.start(4)
        self.wait(self.task_running, "the panel is loaded, which mends all faults")
        inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
        caused = inject(kind="insertion_jammed", target="ask_operator", values=[])
        self.assertTrue(caused.success, caused.message)
        self.wait(lambda: self.last().phase == UseCaseState.ASKING, "the operator is asked")
        question = self.last().question
        self.assertIn("Insertion jammed", question.text)
        wrong = call("answer", AnswerQuestion, question=question.number, choice="maybe", by="ann")
        self.assertFalse(wrong.success)
        given = {"question": question.number, "choice": OperatorQuestion.SKIP, "by": "ann"}
        self.assertTrue(call("answer", AnswerQuestion, **given).success)
        self.wait(lambda: self.last().phase == UseCaseState.RUNNING, "the run goes on")
        self.assertTrue(call("stop", CommandRun, by="ann").success)
        self.wait(lambda: self.last().phase == UseCaseState.ENDED, "the run ends")
        self.wait(lambda: handle.get_result() is not None, "the goal ends")
        self.assertFalse(handle.get_result().success)
        self.assertIn("ann stopped it", self.last().message)
        printed = planner("explain", str(self.last().run))
        self.assertIn("ann: answered: skip", printed.stdout)


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_supervision", SupervisionTest)
