"""A behavior as users write them: polling states, with no knowledge of this engine."""
# ruff: noqa: ANN001, ANN201, ANN204, D102

import time

from actionlib.msg import TestAction, TestGoal
from std_msgs.msg import Float64, String

from flexbe_core import Behavior, EventState, OperatableStateMachine
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


class BenchSM(Behavior):
    """A chain of states between two marks, or a state that sends goals or waits for messages."""

    def __init__(self):
        super().__init__()
        self.name = "Bench"
        self.add_parameter("kind", "chain")
        self.add_parameter("count", 10)

    def create(self):
        root = OperatableStateMachine(outcomes=["finished"])
        labels = [f"State {index}" for index in range(self.count)]
        with root:
            if self.kind == "chain":
                OperatableStateMachine.add("Begin", MarkState(), {"done": labels[0]})
                for label, following in zip(labels, [*labels[1:], "End"], strict=True):
                    OperatableStateMachine.add(label, NothingState(), {"done": following})
                OperatableStateMachine.add("End", MarkState(), {"done": "finished"})
            else:
                state = GoalState if self.kind == "goals" else MessageState
                targets = {"again": "Loop", "done": "finished"}
                OperatableStateMachine.add("Loop", state(self.count), targets)
        return root
