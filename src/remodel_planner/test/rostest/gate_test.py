#!/usr/bin/env python3
"""After a pause, a skip or a stop is answered nothing moves, and the order can always go on."""

import contextlib
import signal
import sqlite3
import subprocess
import time

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from gate_case import OUTPUT, WINDOW_S, GateCase
from order_client import (
    ORDER,
    SUPERVISOR,
    wait_until,
)
from remodel_msgs.msg import (
    ErrorCode,
    UseCaseState,
)
from std_msgs.msg import Bool


class GateTest(GateCase):
    def test_nothing_moves_after_a_pause_is_answered(self):
        self.pause_at_random_moments(1, tasks=2)

    def test_a_running_task_is_skipped_and_done_later(self):
        self.skip_at_random_moments(1, tasks=2)

    def test_a_shutdown_of_the_supervisor_leaves_no_event_and_the_run_is_resumed(self):
        self.end_at_random_moments([signal.SIGINT], tasks=3)

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

    def publish_once(self, data):
        """Publish on the topic as a person does, by a node that ends afterwards."""
        line = ["rostopic", "pub", "--once", "remodel/protective_stop", "std_msgs/Bool", data]
        subprocess.run(line, check=True, timeout=180.0, stdout=subprocess.DEVNULL)

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


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_gate", GateTest)
