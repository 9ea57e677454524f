#!/usr/bin/env python3
"""The proxies, against real topics, services and action servers."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import actionlib
import rospy
import rostest
from actionlib.msg import TestAction, TestFeedback, TestGoal, TestResult
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from flexbe_msgs.msg import BehaviorInputAction, BehaviorInputGoal
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from flexbe_core import EventState
from flexbe_core.proxy import (
    ProxyActionClient,
    ProxyPublisher,
    ProxyServiceCaller,
    ProxySubscriberCached,
    ProxyTransformListener,
)
from flexbe_core.proxy.proxy_action_client import (
    LOST_GRACE_S,
    SILENCE_S,
    ActionConnection,
    ActionServerLostError,
)
from flexbe_core.testing import wait_until

LIMIT_S = 90.0

SERVER = """
import rospy, actionlib
from actionlib.msg import TestAction
rospy.init_node('{node}')
server = actionlib.ActionServer('{topic}', TestAction, lambda h: h.set_accepted(), auto_start=False)
server.start()
rospy.spin()
"""


class ProxiesTest(unittest.TestCase):
    # Topics

    def test_a_message_is_kept_until_it_is_removed(self):
        publisher = ProxyPublisher({"p/one": String}, _latch=True)
        subscriber = ProxySubscriberCached({"p/one": String})
        self.assertTrue(publisher.wait_for_any("p/one"))
        self.assertFalse(subscriber.has_msg("p/one"))
        publisher.publish("p/one", String("hello"))
        self.assertTrue(wait_until(lambda: subscriber.has_msg("p/one")))
        self.assertEqual(subscriber.get_last_msg("p/one").data, "hello")
        other = ProxySubscriberCached({"p/one": String})
        self.assertTrue(other.has_msg("p/one"), "all proxies share it")
        other.remove_last_msg("p/one")
        self.assertFalse(subscriber.has_msg("p/one"))

    def test_a_buffer_keeps_all_messages_in_order(self):
        subscriber = ProxySubscriberCached()
        subscriber.subscribe("p/buffer", String, buffered=True)
        for text in "abc":
            subscriber._callback(String(text), "p/buffer")
        taken = [subscriber.get_from_buffer("p/buffer").data for _ in range(3)]
        self.assertEqual(taken, ["a", "b", "c"])
        self.assertFalse(subscriber.has_buffered("p/buffer"))
        self.assertIsNone(subscriber.get_from_buffer("p/buffer"))
        subscriber.disable_buffer("p/buffer")
        subscriber._callback(String("d"), "p/buffer")
        self.assertIsNone(subscriber.get_from_buffer("p/buffer"))
        subscriber.enable_buffer("p/buffer")
        subscriber._callback(String("e"), "p/buffer")
        subscriber.remove_last_msg("p/buffer", clear_buffer=True)
        self.assertFalse(subscriber.has_buffered("p/buffer"))

    def test_a_persistent_message_stays(self):
        subscriber = ProxySubscriberCached({"p/persistent": String})
        subscriber.make_persistant("p/persistent")
        subscriber._callback(String("stay"), "p/persistent")
        subscriber.remove_last_msg("p/persistent")
        self.assertTrue(subscriber.has_msg("p/persistent"))

    def test_unknown_topics_are_distinguished(self):
        subscriber = ProxySubscriberCached()
        self.assertFalse(subscriber.has_msg("p/unknown"))
        self.assertFalse(subscriber.is_available("p/unknown"))
        with self.assertRaises(KeyError):
            subscriber.get_last_msg("p/unknown")
        ProxyPublisher().publish("p/unknown", String())  # costs a warning only
        self.assertFalse(ProxyPublisher().is_available("p/unknown"))

    def test_callbacks_of_states_end_with_the_state(self):
        heard = []

        class Listening(EventState):
            def __init__(self):
                super().__init__(outcomes=["done"])
                self._sub = ProxySubscriberCached({"p/callback": String})
                self._sub.set_callback("p/callback", self.listen)

            def listen(self, message):
                heard.append(message.data)

        state = Listening()
        state._sub._callback(String("a"), "p/callback")
        del state
        gc.collect()
        ProxySubscriberCached()._callback(String("b"), "p/callback")
        self.assertEqual(heard, ["a"])

    def test_a_subscription_can_be_ended(self):
        subscriber = ProxySubscriberCached({"p/ended": String})
        subscriber.unsubscribe_topic("p/ended")
        self.assertFalse(subscriber.is_available("p/ended"))

    def test_waiting_for_an_absent_subscriber_is_bounded(self):
        publisher = ProxyPublisher({"p/nobody": Empty})
        begin = time.monotonic()
        self.assertFalse(publisher.wait_for_any("p/nobody", timeout=0.7))
        self.assertLess(time.monotonic() - begin, LIMIT_S)

    # Services

    def test_a_service_is_called(self):
        rospy.Service("p/service", Trigger, lambda r: TriggerResponse(True, "well"))
        caller = ProxyServiceCaller({"p/service": Trigger})
        self.assertTrue(caller.is_available("p/service"))
        self.assertEqual(caller.call("p/service", TriggerRequest()).message, "well")

    def test_a_missing_service_is_an_error_within_a_bound(self):
        caller = ProxyServiceCaller({"p/missing": Trigger}, wait_duration=0.2)
        self.assertFalse(caller.is_available("p/missing"))
        with self.assertRaisesRegex(ValueError, "p/missing: it is not there"):
            caller.call("p/missing", TriggerRequest())

    # Actions

    def serve(self, topic):
        """Serve an action; return the list of goals that it accepted."""
        goals = []

        def on_goal(handle):
            goals.append(handle)  # first: once it is accepted, a test goes on
            handle.set_accepted("at work")

        server = actionlib.ActionServer(
            topic, TestAction, on_goal, lambda h: h.set_canceled(TestResult(-1)), auto_start=False
        )
        server.start()
        return goals

    def test_a_goal_goes_from_pending_to_its_result(self):
        goals = self.serve("a/one")
        client = ProxyActionClient({"a/one": TestAction})
        self.assertTrue(client.is_available("a/one"))
        self.assertEqual(client.get_state("a/one"), GoalStatus.LOST)
        client.send_goal("a/one", TestGoal(5))
        self.assertTrue(client.is_active("a/one"))
        self.assertTrue(wait_until(lambda: client.get_state("a/one") == GoalStatus.ACTIVE))
        self.assertEqual(client.get_goal_status_text("a/one"), "at work")
        goals[0].publish_feedback(TestFeedback(3))
        self.assertTrue(wait_until(lambda: client.has_feedback("a/one")))
        self.assertEqual(client.get_feedback("a/one").feedback, 3)
        client.remove_feedback("a/one")
        self.assertFalse(client.has_feedback("a/one"))
        self.assertFalse(client.has_result("a/one"))
        goals[0].set_succeeded(TestResult(7), "well")
        self.assertTrue(wait_until(lambda: client.has_result("a/one")))
        self.assertEqual(client.get_result("a/one").result, 7)
        self.assertEqual(client.get_state("a/one"), GoalStatus.SUCCEEDED)
        self.assertEqual(client.get_goal_status_text("a/one"), "well")
        self.assertFalse(client.is_active("a/one"))
        client.remove_result("a/one")
        self.assertFalse(client.has_result("a/one"))

    def test_goals_belong_to_the_proxy_that_sent_them(self):
        goals = self.serve("a/two")
        first, second = (ProxyActionClient({"a/two": TestAction}) for _ in range(2))
        first.send_goal("a/two", TestGoal(1))
        self.assertTrue(second.is_active("a/two"), "who sent none sees the last of the process")
        second.send_goal("a/two", TestGoal(2))
        self.assertTrue(wait_until(lambda: len(goals) == 2))
        goals[1].set_succeeded(TestResult(2))
        self.assertTrue(wait_until(lambda: second.has_result("a/two")))
        self.assertFalse(first.has_result("a/two"))
        first.cancel("a/two")
        self.assertTrue(wait_until(lambda: first.has_result("a/two")))
        self.assertEqual(first.get_state("a/two"), GoalStatus.PREEMPTED)

    def test_a_missing_server_is_an_error_within_a_bound(self):
        begin = time.monotonic()
        client = ProxyActionClient({"a/missing": TestAction}, wait_duration=0.2)
        self.assertFalse(client.is_available("a/missing"))
        with self.assertRaisesRegex(ValueError, "a/missing: the action server is not there"):
            client.send_goal("a/missing", TestGoal())
        with self.assertRaisesRegex(ValueError, "no client was set up"):
            client.send_goal("a/unknown", TestGoal())
        self.assertLess(time.monotonic() - begin, LIMIT_S)

    def start_server(self, topic, node):
        server = subprocess.Popen([sys.executable, "-c", SERVER.format(topic=topic, node=node)])
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        return server

    def sent_goal(self, topic, node):
        """Return a server process that has accepted a goal, and the client."""
        server = self.start_server(topic, node)
        client = ProxyActionClient({topic: TestAction})
        client.send_goal(topic, TestGoal())
        self.assertTrue(wait_until(lambda: client.get_state(topic) == GoalStatus.ACTIVE))
        return server, client

    def assert_lost(self, client, topic):
        """Check that is_available reports a lost goal first, and then has_result raises."""
        self.assertFalse(client.has_result(topic))
        with self.assertRaises(ActionServerLostError):
            wait_until(lambda: client.has_result(topic), LOST_GRACE_S + 1.0)

    def test_a_killed_server_is_noticed_at_once(self):
        server, client = self.sent_goal("a/killed", "killed")
        server.kill()
        self.assertTrue(wait_until(lambda: not client.is_available("a/killed"), 1.0))
        self.assert_lost(client, "a/killed")

    def test_a_server_that_hangs_is_noticed(self):
        server, client = self.sent_goal("a/hung", "hung")
        os.kill(server.pid, signal.SIGSTOP)
        self.assertTrue(wait_until(lambda: not client.is_available("a/hung"), SILENCE_S + 1.0))
        os.kill(server.pid, signal.SIGCONT)
        self.assertTrue(wait_until(lambda: client.is_available("a/hung"), 1.0), "it is back")
        self.assertFalse(client.has_result("a/hung"))

    def test_a_listener_that_stops_reading_goals_holds_up_no_sender(self):
        """Such as a laptop that records the topics, and goes to sleep."""
        connection = ActionConnection("a/recorded", BehaviorInputAction)
        echo = ("rostopic", "echo", "a/recorded/goal")
        listener = subprocess.Popen(echo, stdout=subprocess.DEVNULL)
        self.addCleanup(listener.wait)
        self.addCleanup(listener.kill)
        publisher = connection._goal_publisher
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() == 1))
        os.kill(listener.pid, signal.SIGSTOP)
        goal = BehaviorInputGoal(msg="x" * 100_000)
        sending = threading.Thread(
            target=lambda: [connection.send(goal) for _ in range(500)], daemon=True
        )
        sending.start()  # far more than the system keeps for a connection
        sending.join(30.0)
        self.assertFalse(sending.is_alive())

    def test_a_goal_is_lost_when_its_server_was_restarted(self):
        server, client = self.sent_goal("a/again", "again")
        server.kill()
        server.wait()
        self.start_server("a/again", "again")
        self.assertTrue(wait_until(lambda: client.get_state("a/again") == GoalStatus.LOST))
        self.assertFalse(client.is_available("a/again"), "for this goal")
        self.assert_lost(client, "a/again")
        client.send_goal("a/again", TestGoal())
        self.assertTrue(wait_until(lambda: client.get_state("a/again") == GoalStatus.ACTIVE))
        self.assertTrue(client.is_available("a/again"))

    def test_goals_reach_a_server_that_starts_again_under_its_name(self):
        """None is sent on the connection to the one that has died."""
        client = ProxyActionClient({"a/respawned": TestAction}, wait_duration=0.0)
        for _ in range(3):
            server = self.start_server("a/respawned", "respawned")
            self.assertTrue(wait_until(lambda: client.is_available("a/respawned")))
            client.send_goal("a/respawned", TestGoal())
            self.assertTrue(
                wait_until(lambda: client.get_state("a/respawned") == GoalStatus.ACTIVE)
            )
            server.kill()
            server.wait()

    def test_a_lost_goal_is_cancelled_in_case_its_server_gets_it_late(self):
        cancelled = []
        rospy.Subscriber("a/late/cancel", GoalID, lambda message: cancelled.append(message.id))
        server, client = self.sent_goal("a/late", "late")
        server.kill()
        server.wait()
        self.start_server("a/late", "late")
        self.assertTrue(wait_until(lambda: client.get_state("a/late") == GoalStatus.LOST))
        client.cancel("a/late")
        self.assertTrue(wait_until(lambda: cancelled))

    def test_all_servers_of_an_action_are_named(self):
        first, client = self.sent_goal("a/shared", "server_1")
        self.assertEqual(client.servers("a/shared"), ("/server_1",))
        self.start_server("a/shared", "server_2")
        statuses = rospy.Publisher("a/shared/status", GoalStatusArray, queue_size=1)  # no server
        self.assertTrue(
            wait_until(lambda: client.servers("a/shared") == ("/server_1", "/server_2"))
        )
        self.assertGreater(statuses.get_num_connections(), 0)
        first.kill()
        self.assertTrue(wait_until(lambda: client.servers("a/shared") == ("/server_2",)))

    # Transforms

    def test_there_is_one_transform_listener(self):
        listener = ProxyTransformListener().listener()
        self.assertIs(ProxyTransformListener().listener(), listener)
        self.assertTrue(hasattr(listener, "lookupTransform"))


if __name__ == "__main__":
    rospy.init_node("test_proxies")
    rostest.rosrun("flexbe_core", "test_proxies", ProxiesTest)
