#!/usr/bin/env python3
"""States that need ROS: time that the test makes, and topics."""

import queue
import threading
import time
import unittest

import rospy
import rostest
from flexbe_msgs.msg import BehaviorLog
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, Empty, String

from flexbe_core import OperatableStateMachine
from flexbe_core.engine.supervision import Preempt
from flexbe_core.ros.session import own_session
from flexbe_core.testing import wait_until
from flexbe_states.log_key_state import LogKeyState
from flexbe_states.log_state import LogState
from flexbe_states.publisher_bool_state import PublisherBoolState
from flexbe_states.publisher_empty_state import PublisherEmptyState
from flexbe_states.publisher_string_state import PublisherStringState
from flexbe_states.subscriber_state import SubscriberState
from flexbe_states.wait_state import WaitState

LIMIT_S = 90.0


class Run:
    """One state, driven in a thread."""

    def __init__(self, state, **inputs):
        self.machine = OperatableStateMachine(outcomes=[f"{name} of it" for name in state.outcomes])
        self.machine.autonomy_level = 255
        for key, value in inputs.items():
            self.machine.userdata[key] = value
        with self.machine:
            transitions = {name: f"{name} of it" for name in state.outcomes}
            OperatableStateMachine.add("state", state, transitions)
        self._outcomes = queue.SimpleQueue()
        threading.Thread(target=self._spin, daemon=True).start()
        wait_until(lambda: own_session(self.machine).active_leaf() is state or self.is_over())

    def _spin(self):
        outcome = self.machine.spin()
        self._outcomes.put((rospy.get_time(), outcome))

    def is_over(self):
        return not self._outcomes.empty()

    def end(self):
        """Return the outcome, without which state it is of."""
        return self._outcomes.get(timeout=LIMIT_S)[1].removesuffix(" of it")

    def ended_at(self):
        return self._outcomes.get(timeout=LIMIT_S)[0]

    def stop(self):
        own_session(self.machine).post(Preempt())
        return self.end()


class StatesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        assert wait_until(lambda: cls.clock.get_num_connections() > 0)
        cls.logs = []
        rospy.Subscriber("flexbe/log", BehaviorLog, cls.logs.append)
        # The first log makes the publisher; those before it is connected are lost.
        assert wait_until(lambda: Run(LogState("is it connected?")).end() and cls.logs)
        # Others may be on their way: all have arrived when the last one has.
        Run(LogState("connected")).end()
        assert wait_until(lambda: cls.logs[-1].text == "connected")

    def setUp(self):
        self.set_time(100.0)
        self.logs.clear()

    def set_time(self, seconds):
        self.clock.publish(rospy.Time.from_sec(seconds))
        self.assertTrue(wait_until(lambda: abs(rospy.get_time() - seconds) < 1e-6))

    def test_a_wait_ends_with_the_first_tick_of_the_clock_that_is_late_enough(self):
        run = Run(WaitState(0.5))
        for milliseconds in range(0, 500, 7):
            self.set_time(100.0 + milliseconds / 1000)
        self.assertFalse(run.is_over())
        self.set_time(100.5)
        self.assertEqual(run.ended_at(), 100.5)

    def test_a_wait_stands_still_with_the_clock(self):
        run = Run(WaitState(0.2))
        time.sleep(0.5)  # the wall clock is what must not count
        self.assertFalse(run.is_over())
        self.set_time(101.0)
        self.assertEqual(run.end(), "done")

    def test_a_wait_can_be_stopped_while_the_clock_stands_still(self):
        run = Run(WaitState(1000))
        self.assertEqual(run.stop(), "preempted")

    def test_a_wait_restarts_with_the_clock(self):
        run = Run(WaitState(5.0))
        now = 1.0
        self.set_time(now)
        while not run.is_over() and now < 60.0:
            now += 0.1
            self.set_time(now)
        ended = run.ended_at()
        self.assertGreaterEqual(ended, 6.0)  # five seconds after it was seen to restart
        self.assertLess(ended, 60.0)

    def test_a_wait_of_nothing_is_over_at_once(self):
        self.assertEqual(Run(WaitState(0)).end(), "done")

    def test_logs_reach_the_operator(self):
        self.assertEqual(Run(LogState("100% of it")).end(), "done")
        self.assertEqual(Run(LogKeyState("it is {}"), data=[7]).end(), "done")
        texts = ["100% of it", "it is [7]"]

        def heard():
            """Return these texts in their order; one of the test before may come late."""
            return [log.text for log in self.logs if log.text in texts]

        wait_until(lambda: heard() == texts)
        self.assertEqual(heard(), texts)

    def test_values_are_published(self):
        for state, message_type, value in (
            (PublisherBoolState("test/bool"), Bool, True),
            (PublisherStringState("test/string"), String, "text"),
        ):
            seen = []
            rospy.Subscriber(state._topic, message_type, seen.append)
            self.assertTrue(state._pub.wait_for_any(state._topic))
            self.assertEqual(Run(state, value=value).end(), "done")
            self.assertTrue(wait_until(lambda seen=seen: seen))
            self.assertEqual(seen[0].data, value)

    def test_a_signal_is_published(self):
        seen = []
        state = PublisherEmptyState("test/empty")
        rospy.Subscriber("test/empty", Empty, seen.append)
        self.assertTrue(state._pub.wait_for_any("test/empty"))
        self.assertEqual(Run(state).end(), "done")
        self.assertTrue(wait_until(lambda: seen))

    def test_a_message_wakes_its_subscriber_without_the_clock(self):
        publisher = rospy.Publisher("test/message", String, queue_size=1)
        run = Run(SubscriberState("test/message"))
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() > 0))
        self.assertFalse(run.is_over())
        publisher.publish("hello")
        self.assertEqual(run.end(), "received")
        self.assertEqual(run.machine._userdata["message"].data, "hello")

    def test_a_message_that_came_before_is_taken_unless_it_is_to_be_cleared(self):
        publisher = rospy.Publisher("test/early", String, queue_size=1)
        state = SubscriberState("test/early")
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() > 0))
        publisher.publish("early")
        self.assertTrue(wait_until(lambda: state._sub.has_msg("test/early")))
        self.assertEqual(
            Run(SubscriberState("test/early", blocking=False, clear=True)).end(), "received"
        )
        publisher.publish("early again")
        self.assertEqual(Run(state).end(), "received")

    def test_an_unknown_topic_is_unavailable(self):
        run = Run(SubscriberState("test/nobody"), message="of an earlier visit")
        self.assertEqual(run.end(), "unavailable")
        self.assertIsNone(own_session(run.machine).userdata()[""]["message"])


if __name__ == "__main__":
    rospy.init_node("test_states")
    rostest.rosrun("flexbe_states", "test_states", StatesTest)
