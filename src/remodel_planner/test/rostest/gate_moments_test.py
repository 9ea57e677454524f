#!/usr/bin/env python3
"""Commands and signals at many random moments of a run, and while the supervisor starts."""

import json
import signal
import time

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from gate_case import WINDOW_S, GateCase
from order_client import ORDER, SUPERVISOR, wait_until
from remodel_msgs.msg import ErrorCode, RunUseCaseActionResult

from remodel_supervision.core.runs.events import Ending


class GateMomentsTest(GateCase):
    def test_nothing_moves_after_a_pause_is_answered(self):
        self.pause_at_random_moments(12, tasks=6)

    def test_a_running_task_is_skipped_and_done_later(self):
        self.skip_at_random_moments(6, tasks=10, kills=(2, 5))

    def test_a_shutdown_of_the_supervisor_leaves_no_event_and_the_run_is_resumed(self):
        self.end_at_random_moments([signal.SIGINT, signal.SIGTERM, signal.SIGINT], tasks=6)

    def test_a_signal_that_arrives_while_the_supervisor_starts_ends_it(self):
        self.orders.end_process(SUPERVISOR)
        for delay_s in (0.0, 0.15):
            until = time.monotonic() + delay_s
            wait_until(lambda t=until: time.monotonic() > t, "a moment of its start")
            self.orders.end_process(SUPERVISOR, signal.SIGTERM)

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

    def test_a_goal_that_waits_for_the_node_does_not_displace_the_unfinished_run(self):
        results = []
        rospy.Subscriber("remodel/run_use_case/result", RunUseCaseActionResult, results.append)
        run = self.orders.start(3)
        self.wait_for_goal()
        # A latched goal: the node that runs refuses it, and so does the next one. It is sent by
        # a node of its own: here it would share the publisher of the client, and latch its goals.
        goal = {
            "goal_id": {"id": "waiting"},
            "goal": {"id": "waiting", "order": ORDER, "tasks": 2, "again": True},
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

    def test_the_wire_held_when_a_run_was_stopped_does_not_hinder_the_next_run(self):
        run = self.orders.start(3)
        wait_until(lambda: self.orders.held, "a wire is held")
        self.orders.require("stop")
        self.assertEqual(self.motions.after(time.time(), WINDOW_S), ())
        state = self.orders.wait_for_end(run)
        self.assertEqual(state.ended.ending, Ending.STOPPED)
        self.assert_complete(self.orders.start(3, again=False))
        self.assertEqual(self.orders.held, "")


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_gate_moments", GateMomentsTest)
