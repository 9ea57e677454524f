#!/usr/bin/env python3
"""A process that is stopped for a while is waited for; a product that is begun is not repeated."""

import os
import shutil
import signal
import sys
import threading
import unittest
from pathlib import Path

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from motion_watch import MotionWatch
from order_client import (
    SUPERVISOR,
    OrderClient,
    import_order,
    wait_until,
)

from remodel_states.testing.world import Deed
from remodel_supervision.core.runs.events import Decided, Ending, TaskBegun

OUTPUT = Path(sys.argv[1])

# [s] wall time for which a process is stopped.
STALL_S = 6.0


class StallsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_stalls")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        import_order(f"sqlite:///{OUTPUT}/production.sqlite")
        cls.orders = OrderClient(OUTPUT)
        cls.motions = MotionWatch(cls.orders.world)

    def assert_sound(self, run):
        """Check that a run is complete, with nothing done twice."""
        state = self.orders.wait_for_end(run)
        self.assertEqual(state.ended.ending, Ending.COMPLETE, state.ended)
        found = self.orders.account(run)
        self.assertEqual((found.fixed_again, found.scrapped, found.omitted), ((), (), ()))

    def stall(self, node, ability, stall_s=STALL_S):
        """Do two tasks, stop a node when an ability has a goal, and check what comes of it."""
        run = self.orders.start(2)
        pid = self.orders.pid(node)
        wait_until(lambda: any(goal.what == ability for goal in self.motions.running), ability)
        os.kill(pid, signal.SIGSTOP)
        try:
            # Nothing is waited for: that much time is to pass.
            self.assertFalse(threading.Event().wait(stall_s))
        finally:
            os.kill(pid, signal.SIGCONT)
        self.assert_sound(run)
        events = self.orders.events(run)
        retried = {e.task for e in events if isinstance(e, TaskBegun) and e.attempt > 1}
        self.assertLessEqual(len(retried), 1)
        faults = {event.fault for event in events if isinstance(event, Decided)}
        self.assertNotIn("result_contradictory", faults)

    def test_the_server_of_a_goal_under_way(self):
        self.stall("screwdriver", "FixCable")

    def test_the_hand(self):
        self.stall("hand", "PickCable")

    def test_the_engine(self):
        self.stall("behavior", "InsertCable")

    def test_the_engine_for_longer_than_it_may_be_silent(self):
        self.stall("behavior", "FixCable", 20.0)

    def test_the_action_server_of_the_engine(self):
        self.stall("behavior_action_server", "InsertCable")

    def test_the_supervisor(self):
        self.stall(SUPERVISOR, "FixCable")

    def test_the_synthesizer(self):
        self.stall("synthesis_server", "LocateGearboxComponent")

    def test_the_next_product_is_begun_once_if_its_supervisor_is_killed_at_once(self):
        self.begin_and_kill(0.0)

    def test_the_next_product_is_begun_once_if_its_supervisor_is_killed_early(self):
        self.begin_and_kill(0.15)

    def test_the_next_product_is_begun_once_if_its_supervisor_is_killed_later(self):
        self.begin_and_kill(0.4)

    def begin_and_kill(self, delay_s):
        wait_until(lambda: self.orders.is_free, "no run is under way")
        before = self.loads()
        handle = self.orders.send(2, again=True)
        wait_until(lambda: handle.get_goal_status() == GoalStatus.ACTIVE, "it is accepted")
        run = self.orders.runs()[0]
        self.assertFalse(threading.Event().wait(delay_s))
        self.orders.end_process(SUPERVISOR)
        self.assert_sound(run)
        self.assertEqual(self.loads(), before + 1, "its panel is loaded once")

    def loads(self):
        return sum(entry.deed is Deed.LOAD for entry in self.orders.world.ledger())


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_stalls", StallsTest)
