#!/usr/bin/env python3
"""Replay the transcripts of FlexBE's wire protocol, see test/transcripts/README.md."""

import queue
import threading
import time
import unittest
from pathlib import Path

import genpy
import roslib.message
import rospy
import rostest
import yaml
from flexbe_msgs.msg import BEStatus
from std_msgs.msg import Empty

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.supervision import checksum
from flexbe_core.testing import is_sent_to

TRANSCRIPTS = Path(__file__).parents[1] / "transcripts"
LIMIT_S = 90.0
QUIET_S = 0.1
NOTHING_RUNS = {"data": ""}
ASKED_BY_MIRRORS = ("flexbe/command/sync", "flexbe/request_mirror_structure")


class Wire:
    """The topics of one file of transcripts, and what the test plays on them."""

    def __init__(self, script):
        self._namespace = script["namespace"]
        self._begun = set()
        self._started, self._ignored = None, ()
        self._library = BehaviorLibrary()
        self._publishers = {
            topic: self._publisher(topic, kind) for topic, kind in script["sends"].items()
        }
        self._arrived = {topic: queue.SimpleQueue() for topic in script["watches"]}
        self._subscribers = [
            rospy.Subscriber(self._namespace + topic, message_class(kind), self._arrived[topic].put)
            for topic, kind in script["watches"].items()
        ]
        self._played = self._play_engine(script["engine"]) if "engine" in script else []
        self._connect()

    def _publisher(self, topic, kind):
        name = self._namespace + topic
        return rospy.Publisher(name, message_class(kind), queue_size=10, tcp_nodelay=True)

    def _play_engine(self, status):
        """Look like an engine that has just said this."""
        name = f"{self._namespace}flexbe/status"
        latched = rospy.Publisher(name, BEStatus, queue_size=10, latch=True)  # of all on the topic
        latched.publish(BEStatus(**status))
        log = self._publisher("flexbe/log", "flexbe_msgs/BehaviorLog")
        beats = rospy.Publisher(f"{self._namespace}flexbe/heartbeat", Empty, queue_size=1)
        self._ended = threading.Event()

        def beat():
            while not self._ended.wait(1.0):
                beats.publish()

        threading.Thread(target=beat, daemon=True).start()
        return [latched, log, beats]

    def _connect(self):
        """Wait until everybody whom the test talks to, or hears, is connected."""
        limit = time.monotonic() + LIMIT_S
        sending = [*self._publishers.values(), *self._played]
        while True:
            lonely = [end.name for end in sending if end.get_num_connections() == 0]
            lonely += [end.name for end in self._subscribers if not is_sent_to(end)]
            if not lonely:
                return
            assert time.monotonic() < limit, f"no connection at {lonely}"
            time.sleep(0.01)

    def close(self):
        if self._played:
            self._ended.set()
        for end in [*self._publishers.values(), *self._subscribers, *self._played]:
            end.unregister()

    def send(self, topic, values):
        publisher = self._publishers[topic]
        message = publisher.data_class()
        genpy.message.fill_message_args(message, [self._filled(values)])
        publisher.publish(message)

    def expect(self, topic, values):
        """Return how the next message of a topic differs; None if it does not."""
        expected = self._filled(values)
        try:
            found = self._next(topic)
            # A mirror that starts publishes once or twice that nothing runs.
            while found == NOTHING_RUNS != expected and topic not in self._begun:
                found = self._next(topic)
        except queue.Empty:
            return f"nothing came on {topic}; expected was {values}"
        if expected != NOTHING_RUNS:
            self._begun.add(topic)
        return None if agrees(found, expected) else f"{topic}: {found}; expected was {expected}"

    def _next(self, topic):
        limit = time.monotonic() + LIMIT_S
        while True:
            try:
                message = self._arrived[topic].get(timeout=QUIET_S)
                return yaml.safe_load(str(message)) or {}
            except queue.Empty:
                if time.monotonic() > limit:
                    raise
            if topic == "flexbe/behavior_update":
                self._answer_a_mirror_that_asks()

    def _answer_a_mirror_that_asks(self):
        """Do as an engine does when a status overtook the structure sent before it.

        Two topics have no order between them. A mirror that has a behavior's structure only after
        its start asks where the behavior is.
        """
        asked = self._arrived["flexbe/command/sync"]
        if not asked.empty() and self._started:
            asked.get()
            self.send("flexbe/mirror/sync", self._started)
            self._started = None  # it moves on from there
            self._ignored = ASKED_BY_MIRRORS  # which ask again if the answer takes long

    def play(self, transcript):
        """Return how the first message that differs does; None if all steps are as expected."""
        self._started, self._ignored = transcript.get("started"), ()
        for step in transcript["steps"]:
            if "send" in step:
                self.send(step["send"], step["message"])
            elif differs := self.expect(step["expect"], step["message"]):
                return differs
        return None

    def rest(self):
        """Return what came besides, within a while."""
        time.sleep(QUIET_S)
        found = []
        for topic, messages in self._arrived.items():
            while not messages.empty():
                text = str(messages.get())
                if topic in self._ignored:
                    continue
                if topic in self._begun or yaml.safe_load(text) != NOTHING_RUNS:
                    found.append((topic, text))
        return found

    def _filled(self, value):
        """Return a value with $id, $checksum and $path put in."""
        if isinstance(value, dict):
            return {key: self._filled(item) for key, item in value.items()}
        if isinstance(value, list):
            return [self._filled(item) for item in value]
        if not isinstance(value, str) or not value.startswith("$"):
            return value
        kind, _, name = value.partition(" ")
        if kind == "$path":
            return checksum(name)
        behavior_id, _ = self._library.find_behavior(name)
        if kind == "$id":
            return behavior_id
        return checksum(Path(self._library.get_sourcecode_filepath(behavior_id)).read_text())


def message_class(kind):
    return roslib.message.get_message_class(kind)


def agrees(found, expected):
    """Return whether a message has the expected values; what is not expected may be anything."""
    if isinstance(expected, dict):
        return all(agrees(found.get(key), value) for key, value in expected.items())
    if isinstance(expected, list):
        return len(found) == len(expected) and all(map(agrees, found, expected))
    return found == expected


class TranscriptsTest(unittest.TestCase):
    def replay(self, name):
        script = yaml.safe_load((TRANSCRIPTS / f"{name}.yaml").read_text())
        wire = Wire(script)
        self.addCleanup(wire.close)
        for transcript in script["transcripts"]:
            differs = wire.play(transcript)
            self.assertIsNone(differs, transcript["name"])
            self.assertEqual(wire.rest(), [], transcript["name"])

    def test_the_mirror(self):
        self.replay("mirror")

    def test_the_launcher(self):
        self.replay("launcher")

    def test_the_action_server(self):
        self.replay("action_server")


if __name__ == "__main__":
    rospy.init_node("test_transcripts")
    rostest.rosrun("flexbe_widget", "test_transcripts", TranscriptsTest)
