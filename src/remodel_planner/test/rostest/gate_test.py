#!/usr/bin/env python3
"""After a pause, a skip or a stop is answered nothing moves, and the order can always go on."""

import contextlib
import json
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import unittest
from pathlib import Path
from random import Random

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from motion_watch import MotionWatch
from order_client import (
    BY_HAND,
    ORDER,
    SUPERVISOR,
    OrderClient,
    import_order,
    wait_until,
)
from pause_moments import PauseMoments
from remodel_msgs.msg import (
    ErrorCode,
    RunUseCaseActionResult,
    TaskState,
    UseCaseState,
)
from std_msgs.msg import Bool

from remodel_supervision.core.runs.events import Blocked, Ending, Interrupted, RunEnded

OUTPUT = Path(sys.argv[1])

# [s] wall time for which nothing may move after an answer: longer than any operation takes.
WINDOW_S = 0.4


class GateTest(unittest.TestCase):
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

    def test_nothing_moves_after_a_pause_is_answered(self):
        random = Random(14)
        moments = PauseMoments(self.orders, self.motions, random)
        while moments.paused < 12:
            run = self.orders.start(6)
            while moments.paused < 12 and moments.pause(run, WINDOW_S):
                pass
            self.assert_complete(run)
        self.assertEqual(moments.moved, [])

    def test_a_running_task_is_skipped_and_done_later(self):
        random = Random(3)
        run = self.orders.start(10)
        skipped = set()
        while len(skipped) < 6:
            before = time.monotonic()
            wait_until(lambda: self.orders.state.task not in ("", *skipped), "the next task")
            task = self.orders.state.task
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
            if len(skipped) in (2, 5):
                self.orders.end_process(SUPERVISOR)
        wait_until(lambda: self.is_set_aside(run, skipped), "the skipped tasks are set aside")
        for task in skipped:
            self.orders.require("retry", task=task)
        self.assert_complete(run)
        self.assertEqual(self.orders.held, "")

    def is_set_aside(self, run, names):
        states = self.orders.task_states(run)
        return all(states[name] == TaskState.SET_ASIDE for name in names)

    def test_a_protective_stop_by_the_topic_cancels_and_holds_until_it_is_released(self):
        run = self.orders.start(3)
        self.wait_for_goal()
        topic = rospy.Publisher("remodel/protective_stop", Bool, queue_size=1, latch=True)
        topic.publish(True)
        self.orders.wait_for_phase(UseCaseState.PROTECTIVE_STOP)
        wait_until(lambda: not self.motions.running, "what ran is cancelled")
        self.assertEqual(self.motions.after(time.time(), WINDOW_S), ())
        granted, text = self.orders.command("resume")
        self.assertFalse(granted)
        self.assertIn("release it first", text)
        self.assertEqual(self.motions.after(time.time(), WINDOW_S), ())
        topic.publish(False)
        wait_until(lambda: self.orders.command("resume")[0], "the run is resumed")
        self.assert_complete(run)

    def test_a_protective_stop_by_the_service_is_answered_when_nothing_moves(self):
        run = self.orders.start(3)
        self.wait_for_goal()
        self.orders.require("protective_stop")
        answered_s = time.time()
        self.assertEqual(self.motions.under_way(answered_s), ())
        self.assertEqual(self.motions.after(answered_s, WINDOW_S), ())
        self.orders.wait_for_phase(UseCaseState.PROTECTIVE_STOP)
        self.orders.require("resume")
        self.assert_complete(run)

    def test_a_protective_stop_without_a_run_refuses_goals_until_it_is_released(self):
        wait_until(lambda: self.orders.is_free, "no run is under way")
        topic = rospy.Publisher("remodel/protective_stop", Bool, queue_size=1, latch=True)
        topic.publish(True)
        wait_until(lambda: "protective stop by" in self.orders.state.message, "it is published")
        before = self.orders.runs()
        handle = self.orders.send(2)
        wait_until(lambda: handle.get_result() is not None, "the goal is answered")
        self.assertEqual(handle.get_goal_status(), GoalStatus.REJECTED)
        self.assertIn("protective stop by", handle.get_goal_status_text())
        self.assertEqual(self.orders.runs(), before)
        with self.publishing("remodel/protective_stop", "std_msgs/Bool", "true"):
            wait_until(lambda: "rostopic" in self.orders.state.message, "both stops are published")
            topic.publish(False)
            mine = rospy.get_name()
            wait_until(lambda: mine not in self.orders.state.message, "its release is published")
            self.assertIn("protective stop by /rostopic", self.orders.state.message)
        self.publish_once("false")
        wait_until(lambda: self.orders.is_free, "the release is published")
        self.assert_complete(self.orders.start(2))

    def test_a_protective_stop_by_the_service_without_a_run_holds_until_it_is_resumed(self):
        wait_until(lambda: self.orders.is_free, "no run is under way")
        granted, text = self.orders.command("protective_stop")
        self.assertTrue(granted, text)
        self.assertIn("no run is under way; the cell is held", text)
        self.orders.end_process(SUPERVISOR, signal.SIGKILL)
        wait_until(
            lambda: "protective stop by" in self.orders.state.message, "it outlives its supervisor"
        )
        handle = self.orders.send(2)
        wait_until(lambda: handle.get_result() is not None, "the goal is answered")
        self.assertEqual(handle.get_goal_status(), GoalStatus.REJECTED)
        self.assertIn("protective stop by", handle.get_goal_status_text())
        self.orders.require("resume")
        wait_until(lambda: self.orders.is_free, "the release is published")
        self.assert_complete(self.orders.start(2))

    def rename_order(self, before, after):
        """Rename an order in the production database, so that it is not found."""
        with contextlib.closing(sqlite3.connect(OUTPUT / "production.sqlite")) as connection:
            connection.execute("UPDATE orders SET name = ? WHERE name = ?", (after, before))
            connection.commit()

    def test_a_run_that_cannot_be_resumed_waits_for_a_person(self):
        run = self.orders.start(3)
        self.wait_for_goal()
        self.rename_order(ORDER, "lost")
        self.orders.end_process(SUPERVISOR, signal.SIGKILL)
        wait_until(lambda: "cannot be resumed" in self.orders.state.message, "it is published")
        self.assertIn(f"no order {ORDER}", self.orders.state.message)
        handle = self.orders.send(2)
        wait_until(lambda: handle.get_result() is not None, "the goal is answered")
        self.assertIn("cannot be resumed", handle.get_goal_status_text())
        self.rename_order("lost", ORDER)
        self.orders.require("resume")
        self.assert_complete(run)

    @contextlib.contextmanager
    def publishing(self, topic, kind, data):
        """Have a second node publish a latched message, and be there meanwhile."""
        line = ["rostopic", "pub", "--latch", topic, kind, data]
        process = subprocess.Popen(line, stdout=subprocess.DEVNULL)
        try:
            yield
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(30.0)

    def publish_once(self, data):
        """Publish on the topic as a person does, by a node that ends afterwards."""
        line = ["rostopic", "pub", "--once", "remodel/protective_stop", "std_msgs/Bool", data]
        subprocess.run(line, check=True, timeout=30.0, stdout=subprocess.DEVNULL)

    def test_the_wire_held_when_a_run_was_stopped_does_not_hinder_the_next_run(self):
        run = self.orders.start(3)
        wait_until(lambda: self.orders.held, "a wire is held")
        self.orders.require("stop")
        self.assertEqual(self.motions.after(time.time(), WINDOW_S), ())
        state = self.orders.wait_for_end(run)
        self.assertEqual(state.ended.ending, Ending.STOPPED)
        self.assert_complete(self.orders.start(3, again=False))
        self.assertEqual(self.orders.held, "")

    def test_a_shutdown_of_the_supervisor_leaves_no_event_and_the_run_is_resumed(self):
        random = Random(2)
        run = self.orders.start(6)
        signals = [signal.SIGINT, signal.SIGTERM, signal.SIGINT]
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

    def test_a_signal_that_arrives_while_the_supervisor_starts_ends_it(self):
        self.orders.end_process(SUPERVISOR)
        for delay_s in (0.0, 0.15):
            until = time.monotonic() + delay_s
            wait_until(lambda t=until: time.monotonic() > t, "a moment of its start")
            self.orders.end_process(SUPERVISOR, signal.SIGTERM)

    def test_of_two_goals_at_once_one_is_refused(self):
        wait_until(lambda: self.orders.is_free, "no run is under way")
        before = self.orders.runs()
        handles = [self.orders.send(6), self.orders.send(6)]
        wait_until(lambda: any(h.get_result() is not None for h in handles), "one is answered")
        answers = [(h.get_goal_status(), h.get_result(), h.get_comm_state()) for h in handles]
        refused = [result for status, result, _ in answers if status == GoalStatus.REJECTED]
        self.assertEqual([each.error_code for each in refused], [ErrorCode.BUSY], answers)
        self.assertEqual(len(self.orders.runs()), len(before) + 1)
        self.assert_complete(self.orders.runs()[0])

    def test_a_goal_that_waits_for_the_node_does_not_displace_the_unfinished_run(self):
        results = []
        rospy.Subscriber("remodel/run_use_case/result", RunUseCaseActionResult, results.append)
        run = self.orders.start(3)
        self.wait_for_goal()
        # A latched goal: the node that runs refuses it, and so does the next one. It is sent by
        # a node of its own: here it would share the publisher of the client, and latch its goals.
        goal = {
            "goal_id": {"id": "waiting"},
            "goal": {"id": "waiting", "order": ORDER, "tasks": BY_HAND + 2, "again": True},
        }
        with self.publishing(
            "remodel/run_use_case/goal", "remodel_msgs/RunUseCaseActionGoal", json.dumps(goal)
        ):
            wait_until(lambda: len(self.refused(results)) == 1, "the running node refuses it")
            self.orders.end_process(SUPERVISOR)
            wait_until(lambda: len(self.refused(results)) == 2, "the next node refuses it")
            self.assertEqual(self.orders.runs()[0], run)
        self.assert_complete(run)

    def refused(self, results):
        return [
            each
            for each in results
            if each.status.goal_id.id == "waiting"
            and each.status.status == GoalStatus.REJECTED
            and each.result.error_code == ErrorCode.BUSY
        ]


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_gate", GateTest)
