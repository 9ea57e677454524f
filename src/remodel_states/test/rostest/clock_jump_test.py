#!/usr/bin/env python3
"""Abilities end as they should when the simulated clock jumps."""

import contextlib
import threading
import time
import unittest

import rospy
import rostest
from remodel_msgs.msg import ErrorCode
from rosgraph_msgs.msg import Clock

from flexbe_core.core import UserData
from flexbe_core.proxy.proxy_action_client import SILENCE_S
from remodel_states.fix_cable_state import FixCableState
from remodel_states.testing import FakeAbility, FakeAnswer

START_S = 1000.0


class SimulatedClock:
    """Publishes `/clock` at the speed of the wall clock."""

    def __init__(self):
        self.now_s = START_S
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        with contextlib.suppress(rospy.ROSException):  # the node ends between test and publishing
            while not rospy.is_shutdown():
                self.now_s += 0.01
                self._publisher.publish(Clock(rospy.Time.from_sec(self.now_s)))
                time.sleep(0.01)


class ClockJumpTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = SimulatedClock()
        cls.fake = FakeAbility("FixCable", [FakeAnswer(hang=True)])

    def outcome(self, state, data, limit_s):
        """Return how a state ends within [s] of wall time; None if it does not."""
        limit = time.monotonic() + limit_s
        outcome = state.execute(data)
        while outcome is None and time.monotonic() < limit:
            time.sleep(0.02)
            outcome = state.execute(data)
        return outcome

    def test_a_clock_that_is_set_back_and_forward_ends_no_goal(self):
        data = UserData()
        for key in ("cable_id", "component_id", "terminal_id"):
            data[key] = key
        self.fake.script(FakeAnswer(hang=True))
        state = FixCableState(timeout_s=20.0)
        self.assertIsNone(self.outcome(state, data, 0.5))
        for jump_s in (-500.0, 10_000.0, -9_500.0):
            self.clock.now_s += jump_s
            # Longer than a server may be silent.
            self.assertIsNone(self.outcome(state, data, SILENCE_S + 1.5), f"after {jump_s} s")
        state.on_exit(data)
        self.fake.script(FakeAnswer(ErrorCode.NOT_SEATED))
        self.assertEqual(self.outcome(FixCableState(), data, 60.0), "failed")
        self.assertEqual(data["error_code"], ErrorCode.NOT_SEATED)


if __name__ == "__main__":
    rospy.init_node("test_clock_jump")
    rostest.rosrun("remodel_states", "test_clock_jump", ClockJumpTest)
