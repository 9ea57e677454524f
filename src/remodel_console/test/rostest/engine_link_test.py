#!/usr/bin/env python3
"""Orders to an engine that connects to one topic after the other."""

import threading
import time
import unittest

import rospy
import rostest
from flexbe_msgs.msg import BehaviorSelection
from std_msgs.msg import Empty, UInt8

from remodel_console.core.run_view import EngineSeen
from remodel_console.core.running import Attach
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.engine_link import EngineLink

LIMIT_S = 60.0


class EngineLinkTest(unittest.TestCase):
    def wait(self, holds, what):
        end_s = time.monotonic() + LIMIT_S
        while not holds():
            self.assertLess(time.monotonic(), end_s, what)
            time.sleep(0.01)

    def test_an_order_waits_until_the_engine_has_subscribed_to_its_topic(self):
        events, attached = [], []
        link = EngineLink(events.append, lambda line: None)
        with self.assertRaisesRegex(CommandError, "no behavior engine is running"):
            link.send(Attach(1))
        heartbeat = rospy.Publisher(topics.HEARTBEAT, Empty, queue_size=1)
        start = rospy.Subscriber(topics.START, BehaviorSelection)
        self.wait(lambda: EngineSeen(True) in events, "the engine is seen")
        with self.assertRaisesRegex(CommandError, f"does not subscribe to {topics.ATTACH}"):
            link.send(Attach(1))
        order = threading.Thread(target=link.send, args=(Attach(2),))
        order.start()
        attach = rospy.Subscriber(topics.ATTACH, UInt8, attached.append)
        order.join(LIMIT_S)
        self.wait(lambda: attached, "the order arrives")
        self.assertEqual(attached, [UInt8(2)])
        for one in (heartbeat, start, attach):
            one.unregister()


if __name__ == "__main__":
    rospy.init_node("test_engine_link")
    rostest.rosrun("remodel_console", "test_engine_link", EngineLinkTest)
