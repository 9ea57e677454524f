"""States as users write them: polling, and with no knowledge of this engine."""
# ruff: noqa: ANN001, ANN201, ANN204, D102

import time

import rospy
from actionlib.msg import TestAction, TestGoal
from std_msgs.msg import Float64, String

from flexbe_core import EventState
from flexbe_core.proxy import ProxyActionClient, ProxyPublisher, ProxySubscriberCached

ACTION = "bench/action"
MESSAGE = "bench/message"
MARKS = "bench/marks"


class GoalState(EventState):
    """Send a goal, wait for the result, so many times as a loop goes."""

    def __init__(self, count):
        super().__init__(outcomes=["again", "done"])
        self._client = ProxyActionClient({ACTION: TestAction})
        self._count = count

    def on_enter(self, userdata):
        self._client.send_goal(ACTION, TestGoal(goal=self._count))

    def execute(self, userdata):
        if not self._client.has_result(ACTION):
            return None
        self._count -= 1
        return "again" if self._count > 0 else "done"

    def on_exit(self, userdata):
        if not self._client.has_result(ACTION):
            self._client.cancel(ACTION)


class MessageState(EventState):
    """Wait for a message and mark when the next visit begins."""

    def __init__(self, count):
        super().__init__(outcomes=["again", "done"])
        self._sub = ProxySubscriberCached({MESSAGE: String})
        self._pub = ProxyPublisher({MARKS: Float64})
        self._count = count

    def on_enter(self, userdata):
        self._sub.remove_last_msg(MESSAGE)
        self._pub.publish(MARKS, Float64(time.time()))

    def execute(self, userdata):
        if not self._sub.has_msg(MESSAGE):
            return None
        self._count -= 1
        return "again" if self._count > 0 else "done"


class MarkState(EventState):
    """Mark when it is entered."""

    def __init__(self):
        super().__init__(outcomes=["done"])
        self._pub = ProxyPublisher({MARKS: Float64})

    def on_enter(self, userdata):
        self._pub.publish(MARKS, Float64(time.time()))

    def execute(self, userdata):
        return "done"


class NothingState(EventState):
    """Do nothing."""

    def __init__(self):
        super().__init__(outcomes=["done"])

    def execute(self, userdata):
        return "done"


class LoopState(EventState):
    """Count rounds of a loop."""

    def __init__(self, rounds):
        super().__init__(outcomes=["again", "done"])
        self._rounds = rounds

    def execute(self, userdata):
        self._rounds -= 1
        return "again" if self._rounds > 0 else "done"


class OvershootState(EventState):
    """Mark how late [s] a wait that began with the last visit was over."""

    def __init__(self, wait_s):
        super().__init__(outcomes=["done"])
        self._pub = ProxyPublisher({MARKS: Float64})
        self._wait_s = wait_s
        self._last = None

    def on_enter(self, userdata):
        now = rospy.get_time()
        if self._last is not None:
            self._pub.publish(MARKS, Float64(now - self._last - self._wait_s))
        self._last = now

    def execute(self, userdata):
        return "done"
