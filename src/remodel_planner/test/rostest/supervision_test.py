#!/usr/bin/env python3
"""A run goes on when its processes are killed, asks an operator, and plays back to itself."""

import os
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import rosgraph
import rospy
import rostest
from order_client import BY_HAND, DESIGN
from remodel_msgs.msg import (
    ErrorCode,
    LayWireActionGoal,
    LayWireActionResult,
    OperatorQuestion,
    RunUseCaseAction,
    RunUseCaseGoal,
    TaskState,
    UseCaseState,
)
from remodel_msgs.srv import AnswerQuestion, CommandRun, GetRun, GetTasks, InjectFault, ListRuns

from remodel_states.edge.exported_tables import read_abilities
from remodel_states.testing.ledger import account
from remodel_states.testing.world_file import WorldFile

OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
LIMIT_S = 120.0


def planner(*line):
    """Run a command of the planner to its end."""
    line = ["rosrun", "remodel_planner", "planner", *line, "--database", DATABASE]
    return subprocess.run(line, capture_output=True, text=True, timeout=60, check=False)


def call(name, kind, **request):
    """Call a service of the supervisor."""
    rospy.wait_for_service(f"remodel/use_case/{name}", 30.0)
    return rospy.ServiceProxy(f"remodel/use_case/{name}", kind)(**request)


class SupervisionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_supervision")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        imported = planner("import", DESIGN, "--order", "house")
        assert imported.returncode == 0, imported.stderr
        cls.states = []
        rospy.Subscriber("remodel/use_case/state", UseCaseState, cls.states.append)

    def wait(self, holds, what):
        end = time.monotonic() + LIMIT_S
        while not holds():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.01)

    def last(self):
        return self.states[-1] if self.states else UseCaseState()

    def pid(self, node):
        """Return a node's process; 0 if it does not answer."""
        try:
            return ServerProxy(rosgraph.Master("/test").lookupNode(f"/{node}")).getPid("/test")[2]
        except (OSError, rosgraph.MasterError):
            return 0

    def kill(self, node):
        """Kill a node, and return when roslaunch has started it again."""
        before = self.pid(node)
        os.kill(before, signal.SIGKILL)
        self.wait(lambda: self.pid(node) not in (0, before), f"{node} respawns")

    def start(self, tasks, again=True):
        """Have tasks for robots of the order done, and return the client when the run has begun."""
        client = actionlib.ActionClient("remodel/run_use_case", RunUseCaseAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(30.0)))
        free = (UseCaseState.IDLE, UseCaseState.ENDED)
        self.wait(lambda: self.last().phase in free, "no run is under way")
        run = self.last().run
        goal = RunUseCaseGoal(id="test", order="house", tasks=BY_HAND + tasks, again=again)
        handle = client.send_goal(goal)
        self.wait(lambda: self.last().run > run, "the run begins")
        return handle

    def record_of(self, run):
        """Yield the entries of a run with their pictures, of which an answer holds few."""
        first = 1
        while entries := call("record", GetRun, run=run, first=first, with_pictures=True).entries:
            yield from entries
            first += len(entries)

    def task_running(self):
        return bool(self.last().task)

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
        self.assertEqual((runs[0].run, runs[0].ended, runs[0].done), (state.run, True, 3))
        self.assertTrue(any(entry.picture.data for entry in self.record_of(state.run)))

    def test_an_operator_answers_and_stops(self):
        rospy.wait_for_service("cell/inject_fault", 30.0)
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
        self.assertIn("ann answered skip to question 1", printed.stdout)

    def test_nothing_moves_after_a_motion_fault_that_a_killed_supervisor_did_not_keep(self):
        self.kill_during_a_motion_fault("use_case_supervisor")

    def test_nothing_moves_after_a_motion_fault_that_a_killed_engine_did_not_report(self):
        self.kill_during_a_motion_fault("behavior")

    def kill_during_a_motion_fault(self, node):
        """Kill a node before it learns that an arm has stopped; check that a person is asked."""
        rospy.wait_for_service("cell/inject_fault", 30.0)
        victim = self.pid(node)
        faults, stopped, blocked, begun = [], [], [], []

        def on_goal(_):
            """Stop the node before the operation ends."""
            if faults and not stopped:
                stopped.append(os.kill(victim, signal.SIGSTOP))

        goals = [
            rospy.Subscriber(
                f"remodel_abilities/{ability.lower()}/goal", rospy.AnyMsg, begun.append
            )
            for ability in read_abilities()
        ]
        lay = "remodel_abilities/laywire"
        layings = rospy.Subscriber(f"{lay}/goal", LayWireActionGoal, on_goal)
        results = rospy.Subscriber(f"{lay}/result", LayWireActionResult, blocked.append)
        inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
        self.start(2)
        self.wait(self.task_running, "the panel is loaded, which mends all faults")
        caused = inject(kind="motion_blocked", target="ask_operator", values=[])
        self.assertTrue(caused.success, caused.message)
        faults.append(caused)
        self.wait(lambda: stopped and blocked, "the arm is stopped")
        self.assertEqual(blocked[-1].result.error_code, ErrorCode.MOTION_FAULT)
        before = len(begun)
        os.kill(victim, signal.SIGKILL)
        self.wait(lambda: self.pid(node) not in (0, victim), f"{node} respawns")
        self.wait(lambda: self.last().phase == UseCaseState.ASKING, "the operator is asked")
        self.assertEqual(len(begun), before, "nothing begins before the answer")
        question = self.last().question
        self.assertIn("Motion blocked", question.text)
        given = {"question": question.number, "choice": OperatorQuestion.STOP, "by": "ann"}
        self.assertTrue(call("answer", AnswerQuestion, **given).success)
        self.wait(lambda: self.last().phase == UseCaseState.ENDED, "the run ends")
        self.assertIn("had ended", planner("explain", str(self.last().run)).stdout)
        for subscriber in (*goals, results, layings):
            subscriber.unregister()


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_supervision", SupervisionTest)
