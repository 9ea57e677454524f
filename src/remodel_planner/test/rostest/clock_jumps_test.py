#!/usr/bin/env python3
"""A run, and the run after it, are completed although /clock jumps back and forward."""

import contextlib
import shutil
import sys
import threading
import time
import unittest
from pathlib import Path

import rospy
import rostest
from order_client import OrderClient, import_order, wait_until
from rosgraph_msgs.msg import Clock

from remodel_supervision.core.runs.events import Decided, Ending

OUTPUT = Path(sys.argv[1])

# [s] wall time between two messages.
EVERY_S = 0.02


class JumpingClock:
    """Publishes the wall's clock, shifted."""

    def __init__(self):
        self.shift_s = 1000.0
        self._begun = time.monotonic()
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=1)
        threading.Thread(target=self._tick, name="clock", daemon=True).start()

    def jump(self, by_s):
        """Shift the clock, and return once it is seen."""
        before = rospy.get_time()
        self.shift_s += by_s
        wait_until(lambda: abs(rospy.get_time() - before - by_s) < 1.0, "the jump is seen")

    def _tick(self):
        while not rospy.is_shutdown():
            now = rospy.Time.from_sec(self.shift_s + time.monotonic() - self._begun)
            with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
                self._publisher.publish(Clock(now))
            time.sleep(EVERY_S)


class ClockJumpsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_clock_jumps")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        import_order(f"sqlite:///{OUTPUT}/production.sqlite")
        cls.clock = JumpingClock()
        cls.orders = OrderClient(OUTPUT)

    def assert_complete(self, run):
        state = self.orders.wait_for_end(run)
        self.assertEqual(state.ended.ending, Ending.COMPLETE, state.ended)
        found = self.orders.account(run)
        self.assertEqual((found.fixed_again, found.scrapped, found.omitted), ((), (), ()))
        decided = [event for event in self.orders.events(run) if isinstance(event, Decided)]
        self.assertEqual(decided, [], "no jump is a failure")

    def test_jumps_during_a_run_harm_neither_it_nor_the_next_one(self):
        run = self.orders.start(6)
        for jump_s in (-100.0, 10_000.0, -100.0):
            before = self.orders.state.task
            wait_until(lambda b=before: self.orders.state.task not in ("", b), "the next task")
            self.clock.jump(jump_s)
        self.assert_complete(run)
        self.assert_complete(self.orders.start(2))


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_clock_jumps", ClockJumpsTest)
