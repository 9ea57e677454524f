#!/usr/bin/env python3
"""Commands and signals at many random moments of a run, and while the supervisor starts."""

import signal
import time

import rostest
from actionlib_msgs.msg import GoalStatus
from gate_case import GateCase
from order_client import SUPERVISOR, wait_until


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


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_gate_moments", GateMomentsTest)
