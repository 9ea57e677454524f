"""What the tests of commands share: an order over a launched fake cell, and what moves there."""

import contextlib
import os
import secrets
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path
from random import Random

import rospy
from motion_watch import MotionWatch
from order_client import SUPERVISOR, OrderClient, import_order, wait_until
from pause_moments import PauseMoments
from remodel_msgs.msg import TaskState, UseCaseState

from remodel_supervision.core.runs.events import Blocked, Ending, Interrupted, RunEnded

OUTPUT = Path(sys.argv[1])

# [s] wall time for which nothing may move after an answer: longer than any operation takes.
WINDOW_S = 0.4


class GateCase(unittest.TestCase):
    """Runs orders, and gives commands at random moments."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_gate")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        import_order(f"sqlite:///{OUTPUT}/production.sqlite")
        cls.orders = OrderClient(OUTPUT)
        cls.motions = MotionWatch(cls.orders.world)

    def assert_complete(self, run, done=()):
        """Check that a run is over, with all tasks done, and nothing done twice."""
        state = self.orders.wait_for_end(run)
        self.assertEqual(state.ended.ending, Ending.COMPLETE, state.ended)
        self.assert_sound(run)

    def assert_sound(self, run):
        found = self.orders.account(run)
        self.assertEqual((found.fixed_again, found.scrapped), ((), ()))
        if self.orders.run_state(run).ended.ending is Ending.COMPLETE:
            self.assertEqual(found.omitted, ())

    def wait_for_goal(self):
        """Wait until an ability has a goal."""
        wait_until(lambda: self.motions.running, "an ability has a goal")

    @contextlib.contextmanager
    def random_moments(self):
        """Yield a fresh source of random moments; a failure states its seed."""
        seed = int(os.environ.get("FRESH_SEED", secrets.randbelow(1_000_000)))
        try:
            yield Random(seed)
        except AssertionError as error:
            raise AssertionError(f"with FRESH_SEED={seed}: {error}") from error

    def pause_at_random_moments(self, count, tasks):
        """Pause runs of so many tasks so often, and check that nothing moves after an answer."""
        with self.random_moments() as random:
            moments = PauseMoments(self.orders, self.motions, random)
            while moments.paused < count:
                run = self.orders.start(tasks)
                while moments.paused < count and moments.pause(run, WINDOW_S):
                    pass
                self.assert_complete(run)
            self.assertEqual(moments.moved, [])

    def skip_at_random_moments(self, count, tasks, kills=()):
        """Skip so many running tasks of a run, and have them done later.

        Args:
            count: how many.
            tasks: of the run.
            kills: after which of the skipped tasks the supervisor is killed.
        """
        with self.random_moments() as random:
            run = self.orders.start(tasks)
            skipped = set()
            while len(skipped) < count:
                before = time.monotonic()
                wait_until(
                    lambda r=run: self.orders.state.task not in ("", *skipped) or self.is_over(r),
                    "the next task",
                )
                task = self.orders.state.task
                if self.is_over(run):  # each of its tasks had ended before it could be skipped
                    self.assertEqual(skipped, set())
                    run = self.orders.start(tasks)
                    continue
                until = before + random.uniform(0.0, 1.0)
                wait_until(
                    lambda t=until, n=task: time.monotonic() > t or self.orders.state.task != n,
                    "a random moment",
                )
                granted, text = self.orders.command("skip", task=task)
                answered_s = time.time()
                if not granted:
                    self.assertIn("cannot be skipped", text)
                    continue
                skipped.add(task)
                self.assertEqual(self.motions.under_way(answered_s), (), f"{task} moves")
                if len(skipped) in kills:
                    self.orders.end_process(SUPERVISOR)
            wait_until(lambda: self.is_set_aside(run, skipped), "the skipped tasks are set aside")
            for task in skipped:
                self.orders.require("retry", task=task)
            self.assert_complete(run)
            self.assertEqual(self.orders.held, "")

    def is_over(self, run):
        state = self.orders.state
        return state.run == run and state.phase == UseCaseState.ENDED

    def is_set_aside(self, run, names):
        states = self.orders.task_states(run)
        return all(states[name] == TaskState.SET_ASIDE for name in names)

    def end_at_random_moments(self, signals, tasks):
        """End the supervisor by signals during a run, which is resumed each time."""
        with self.random_moments() as random:
            run = self.orders.start(tasks)
            # Before its first task a run has nothing that could be interrupted.
            wait_until(lambda: self.orders.state.task, "the first task")
            for count, number in enumerate(signals):
                wait_until(lambda n=count: self.orders.state.interruptions == n, "it is resumed")
                until = time.monotonic() + random.uniform(0.1, 1.0)
                wait_until(lambda t=until: time.monotonic() > t, "a random moment")
                self.orders.end_process(SUPERVISOR, number)
            self.assert_complete(run)
            events = self.orders.events(run)
            self.assertEqual([event for event in events if isinstance(event, Blocked)], [])
            self.assertEqual(sum(isinstance(event, Interrupted) for event in events), len(signals))
            self.assertEqual(sum(isinstance(event, RunEnded) for event in events), 1)

    @contextlib.contextmanager
    def publishing(self, topic, kind, data):
        """Have a second node publish a latched message, and be there meanwhile."""
        line = ["rostopic", "pub", "--latch", topic, kind, data]
        process = subprocess.Popen(line, stdout=subprocess.DEVNULL)
        try:
            yield
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(180.0)
