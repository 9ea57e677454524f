#!/usr/bin/env python3
"""The mirror beside a real engine: who joins late learns the truth."""

import os
import signal
import unittest
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
import rostest
from flexbe_msgs.msg import BehaviorSelection, BEStatus
from std_msgs.msg import Empty, String

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.supervision import checksum
from flexbe_core.testing import wait_until


class Recorder:
    """Remembers what comes on a topic."""

    def __init__(self, topic, message_type):
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, message_type, self.messages.append)

    def wait(self, matches):
        return wait_until(lambda: any(map(matches, self.messages)))

    def close(self):
        self._subscriber.unregister()


class MirrorTest(unittest.TestCase):
    def setUp(self):
        self.status = Recorder("flexbe/status", BEStatus)
        self.start = rospy.Publisher("flexbe/start_behavior", BehaviorSelection, queue_size=1)
        self.preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=1)
        self.assertTrue(self.status.wait(lambda m: m.code != BEStatus.STARTED))

    def tearDown(self):
        self.preempt.publish()
        self.status.wait(lambda m: m.code in (BEStatus.FINISHED, BEStatus.READY))
        self.status.close()

    def begin(self, name="Quick Test", **parameters):
        """Start a behavior under supervision, so that only the mirror shows where it is."""
        library = BehaviorLibrary()
        behavior_id, _ = library.find_behavior(name)
        with open(library.get_sourcecode_filepath(behavior_id)) as file:
            behavior_checksum = checksum(file.read())
        while not self.start.get_num_connections() or not self.preempt.get_num_connections():
            rospy.sleep(0.01)
        self.status.messages.clear()
        self.start.publish(
            BehaviorSelection(
                *(behavior_id, behavior_checksum, 3),
                *(list(parameters), list(map(str, parameters.values())), [], [], []),
            )
        )
        self.assertTrue(self.status.wait(lambda m: m.code == BEStatus.STARTED))

    def assert_shown(self, path):
        """Check that who joins now learns this path."""
        late = Recorder("flexbe/behavior_update", String)
        self.assertTrue(late.wait(lambda m: m.data == path), late.messages)
        late.close()

    def pid(self, node):
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
        return ServerProxy(uri).getPid(rospy.get_name())[2]

    def kill(self, node):
        os.kill(self.pid(node), signal.SIGKILL)

    def test_who_joins_late_learns_where_the_behavior_is_and_when_it_ended(self):
        self.begin(wait_time=60)
        self.assert_shown("/Wait")
        self.preempt.publish()
        self.assertTrue(self.status.wait(lambda m: m.args == ["preempted"]))
        self.assert_shown("")

    def test_a_mirror_that_is_killed_finds_the_behavior_again(self):
        self.begin(wait_time=60)
        self.assert_shown("/Wait")
        self.kill("/behavior_mirror")
        self.assert_shown("/Wait")

    def test_an_engine_that_stood_still_is_shown_again(self):
        self.begin(wait_time=60)
        self.assert_shown("/Wait")
        engine = self.pid("/behavior")
        os.kill(engine, signal.SIGSTOP)
        try:
            self.assert_shown("")
        finally:
            os.kill(engine, signal.SIGCONT)
        self.assert_shown("/Wait")

    def test_an_engine_that_is_killed_runs_nothing_any_more(self):
        self.begin(wait_time=60)
        self.assert_shown("/Wait")
        self.kill("/behavior")
        self.assertTrue(self.status.wait(lambda m: m.code == BEStatus.READY))
        self.assert_shown("")

    def test_every_path_that_is_published_was_active_and_in_the_order_of_the_run(self):
        shown, visits = Recorder("flexbe/behavior_update", String), Recorder("test/visits", String)
        self.begin("Joins Test", joins=100)
        self.assertTrue(self.status.wait(lambda m: m.code == BEStatus.FINISHED))
        self.assertTrue(visits.wait(lambda m: m.data == "exit /last"))
        paths = [message.data for message in shown.messages if message.data]
        log = [message.data.split() for message in visits.messages]
        shown.close()
        visits.close()
        self.assertGreater(len(paths), 100)
        moments = active_paths(log)
        moment = 0
        for path in paths:
            while path not in moments[moment]:
                moment += 1
                self.assertLess(moment, len(moments), f"{path} was not active any more, or never")


def active_paths(log):
    """Return the active paths after each entry in a log of visits."""
    active, moments = frozenset(), []
    for event, path in log:
        active = active | {path} if event == "enter" else active - {path}
        moments.append(active)
    return moments


if __name__ == "__main__":
    rospy.init_node("test_mirror")
    rostest.rosrun("flexbe_mirror", "test_mirror", MirrorTest)
