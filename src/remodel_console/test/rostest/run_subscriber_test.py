#!/usr/bin/env python3
"""The console has the tasks that the planner's code publishes, though messages are lost."""

import sys
import threading
import unittest
from pathlib import Path

import rospy
import rostest

sys.path.insert(0, str(Path(__file__).parent))
from fake_supervisor import FakeSupervisor

from remodel_console.ros.use_case_link import RunSubscriber
from remodel_run.progress import Phase, TaskPhase
from remodel_supervision.core.runs.events import (
    Command,
    Commanded,
    Part,
    Planned,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.state import FINISHED

LIMIT_S = 60.0
DONE, ASIDE, RUNS, WAITS = (
    TaskPhase.DONE,
    TaskPhase.SET_ASIDE,
    TaskPhase.RUNNING,
    TaskPhase.WAITING,
)


class RunSubscriberTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_run_subscriber")
        cls.supervisor = FakeSupervisor()

    def setUp(self):
        self.taken = []
        self.new = threading.Condition()
        self.subscriber = RunSubscriber(self.take)

    def take(self, use_case):
        with self.new:
            self.taken.append(use_case)
            self.new.notify_all()

    def wait(self, holds, what):
        """Wait until a run that was passed on last fulfils a condition."""
        with self.new:
            so = self.new.wait_for(lambda: self.taken and holds(self.taken[-1]), LIMIT_S)
        self.assertTrue(so, f"{what}; last: {self.taken[-1:]}")
        return self.taken[-1]

    def wait_for(self, *phases):
        """Wait until the tasks have these phases, by their names."""
        wanted = {f"W{place}": phase for place, phase in enumerate(phases, start=1)}
        return self.wait(lambda run: {t.name: t.phase for t in run.tasks} == wanted, wanted)

    def test_changes_that_are_lost_are_made_up_for(self):
        supervisor = self.supervisor
        self.wait(lambda run: run.phase is Phase.IDLE, "the state of no run")
        supervisor.run("cabinet 7")
        run = self.wait_for(DONE, DONE, ASIDE, RUNS, WAITS, WAITS)
        self.assertFalse([run for run in self.taken if run.run and not run.tasks], "no tasks shown")
        self.assertEqual((run.sums.tasks, run.sums.done, run.sums.skipped), (6, 2, 1))
        self.assertEqual([failure.task for failure in run.failures], ["W2", "W3"])

        supervisor.add(TaskEnded("W4", FINISHED, 30.0, True))
        self.wait_for(DONE, DONE, ASIDE, DONE, WAITS, WAITS)

        topic, lost = supervisor.publisher._changes, []
        supervisor.publisher._changes = type("Lossy", (), {"publish": staticmethod(lost.append)})()
        supervisor.add(
            TaskBegun("W5", 1, part=Part.WHOLE, behavior="Connect W5", chart="", at_s=0.0)
        )
        self.wait_for(DONE, DONE, ASIDE, DONE, RUNS, WAITS)
        self.assertEqual(len(lost), 1)
        supervisor.publisher._changes = topic

        supervisor.add(TaskEnded("W5", FINISHED, 30.0, True))
        supervisor.add(Commanded(Command.RETRY, "W3", "ann"), Planned(("W6", "W3"), "because"))
        run = self.wait_for(DONE, DONE, WAITS, DONE, DONE, WAITS)
        self.wait(lambda run: [task.name for task in run.tasks[4:]] == ["W6", "W3"], "the order")

        # The supervisor is killed and resumes the run: its changes are numbered again.
        supervisor.restart()
        self.wait(lambda run: run.interruptions == 2, "the run is resumed")
        supervisor.add(
            TaskBegun("W6", 1, part=Part.WHOLE, behavior="Connect W6", chart="", at_s=0.0)
        )
        self.wait_for(DONE, DONE, WAITS, DONE, DONE, RUNS)


if __name__ == "__main__":
    rostest.rosrun("remodel_console", "test_run_subscriber", RunSubscriberTest)
