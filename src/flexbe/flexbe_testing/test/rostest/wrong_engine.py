"""A foreign engine that breaks rules: a relay before a real engine, which changes what passes.

A fault changes the messages of one topic. A change takes a message and the relay, and returns the
messages to pass on instead; it may also send others.
"""

import functools
import threading

import rospy
from flexbe_msgs.msg import BEStatus
from flexbe_msgs.srv import GetUserdata
from roslib.message import get_message_class
from std_msgs.msg import Empty

from flexbe_core.testing import is_sent_to
from flexbe_testing.core import topics

INNER = "inner"
LIMIT_S = 60.0
GATES = [
    f"conformance/{name}"
    for name in (
        *("first", "second", "leaf", "tail", "last", "after", "left", "right"),
        *("calm", "wait", "act", "hold"),
    )
]


# The action server that starts behaviors.
EXECUTE = topics.EXECUTE_ACTION
_ACTION = "flexbe_msgs/BehaviorExecutionAction"
GOALS = {f"{EXECUTE}/goal": f"{_ACTION}Goal", f"{EXECUTE}/cancel": "actionlib_msgs/GoalID"}
RESULTS = {
    f"{EXECUTE}/status": "actionlib_msgs/GoalStatusArray",
    f"{EXECUTE}/feedback": f"{_ACTION}Feedback",
    f"{EXECUTE}/result": f"{_ACTION}Result",
}


class WrongEngine:
    """An engine in this node's namespace, which is the one in the namespace inner, but for a fault.

    Attributes:
        faults: topic -> change; a service has its name for a topic, and its response is changed.
        memory: what changes remember from one message to the next.
    """

    def __init__(self, faults):
        self.faults, self.memory = dict(faults), {}
        self._running, self._news = False, threading.Condition()
        kinds = {**topics.COMMANDS, **dict.fromkeys(GATES, "std_msgs/String"), **GOALS}
        published = {**topics.PUBLISHED, **RESULTS}
        self._inward = {topic: self._out(f"{INNER}/{topic}", kind) for topic, kind in kinds.items()}
        self._outward = {
            topic: self._out(topic, kind, latch=topic == topics.STATUS)
            for topic, kind in published.items()
        }
        for topic in (topics.START, *GOALS):
            wait_until(lambda end=self._inward[topic]: end.get_num_connections() > 0)
        self._subscribers = [
            rospy.Subscriber(
                topic, get_message_class(kind), functools.partial(self._pass, topic, self.inward)
            )
            for topic, kind in kinds.items()
        ]
        self._subscribers += [
            rospy.Subscriber(
                f"{INNER}/{topic}",
                get_message_class(kind),
                functools.partial(self._pass, topic, self.outward),
            )
            for topic, kind in published.items()
        ]
        # What the real engine publishes before it is connected is lost.
        for subscriber in self._subscribers[len(kinds) :]:
            wait_until(lambda end=subscriber: is_sent_to(end))
        self._ask = rospy.ServiceProxy(f"{INNER}/{topics.USERDATA_SERVICE}", GetUserdata)
        self._service = rospy.Service(topics.USERDATA_SERVICE, GetUserdata, self._on_ask)

    def inward(self, topic, message):
        """Publish to the real engine."""
        publisher = self._inward[topic]
        wait_until(lambda: publisher.get_num_connections() > 0)
        publisher.publish(message)

    def outward(self, topic, message):
        """Publish as the engine."""
        self._outward[topic].publish(message)

    def set_latched(self, is_latched):
        """Send the last status to who subscribes later, or do not."""
        self._outward[topics.STATUS].impl.is_latch = is_latched

    def rest(self):
        """Forget all faults, and stop what the real engine runs."""
        self.faults.clear()
        self.memory.clear()
        with self._news:
            if self._running:
                self.inward(topics.PREEMPT, Empty())
                assert self._news.wait_for(lambda: not self._running, LIMIT_S)

    def _out(self, topic, kind, latch=False):
        kind = get_message_class(kind)
        return rospy.Publisher(topic, kind, latch=latch, queue_size=100, tcp_nodelay=True)

    def _pass(self, topic, onward, message):
        change = self.faults.get(topic)
        for changed in [message] if change is None else change(message, self):
            onward(topic, changed)
        if topic == topics.STATUS and message.code != BEStatus.ERROR:
            with self._news:
                self._running = message.code in (BEStatus.STARTED, BEStatus.SWITCHING)
                self._news.notify_all()

    def _on_ask(self, request):
        response = self._ask(request)
        change = self.faults.get(topics.USERDATA_SERVICE)
        return response if change is None else change(response, self)


def wait_until(condition):
    """Poll until a connection is made, of which rospy has no notification."""
    end = rospy.get_time() + LIMIT_S
    while not condition():
        assert rospy.get_time() < end, f"a topic of the engine is not connected within {LIMIT_S} s"
        rospy.sleep(0.002)
