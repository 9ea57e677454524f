"""The connection of a process to one action server, and waits for nodes not there yet."""

from __future__ import annotations

import itertools
import threading
import time
import weakref
from collections.abc import Callable

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from genpy import Message

from flexbe_core.ros import clock
from flexbe_core.ros.driver import Waiting
from flexbe_core.ros.master import hears, senders


class Waits:
    """What the process has made of the waits of its proxies; an engine reports them to operators.

    Attributes:
        report: gets in words what is waited for.
        is_stopped: returns whether nothing is to be waited for any more.
    """

    def __init__(self) -> None:
        self.report: Callable[[str], None] = _log
        self.is_stopped: Callable[[], bool] = lambda: False


def _log(text: str) -> None:
    rospy.logwarn("%s", text)


# Connections belong to the process, and so do the waits for them.
WAITS = Waits()


# [s] A server publishes its status at 5 Hz of ROS time. If it is silent this long, in ROS time as
# well as in wall time (ROS time may be stopped, or ten times as fast), it hangs.
SILENCE_S = 5.0

# [s] Wall time between two checks whether the connection is complete; rospy has no callback for it.
_CHECK_EVERY_S = 0.01

# [s] Wall time after which waiting for a server is logged.
_LOG_AFTER_S = 0.5

_goal_numbers = itertools.count(1)


class ActionConnection:
    """Goals out; statuses, feedback and results in.

    Attributes:
        latest: the goal that was sent last.
        for_result: states that wait for a result.
        for_feedback: states that wait for feedback.
        for_status: states that wait for a change of status.
    """

    def __init__(self, topic: str, action_type: type[Message]) -> None:
        """Connect to the server at `topic`, now or when it starts."""
        action = action_type()
        self._topic = topic
        self._goal_type = type(action.action_goal)
        self.latest: Goal | None = None
        self.for_result = Waiting()
        self.for_feedback = Waiting()
        self.for_status = Waiting()
        self._goals: weakref.WeakValueDictionary[str, Goal] = weakref.WeakValueDictionary()
        self._heard_wall = time.monotonic()
        self._heard_ros = clock.now()
        self._changed = threading.Event()
        # With a queue, whose threads write: anybody may listen to goals, and stop reading.
        self._goal_publisher = rospy.Publisher(f"{topic}/goal", self._goal_type, queue_size=10)
        self._cancel_publisher = rospy.Publisher(f"{topic}/cancel", GoalID, queue_size=10)
        self._subscribers = [
            rospy.Subscriber(f"{topic}/{name}", message_type, callback, tcp_nodelay=True)
            for name, message_type, callback in (
                ("status", GoalStatusArray, self._on_status),
                ("feedback", type(action.action_feedback), self._on_feedback),
                ("result", type(action.action_result), self._on_result),
            )
        ]

    def is_available(self) -> bool:
        """Return whether a server is connected on all topics and gives signs of life."""
        if not self._is_connected():
            return False
        wall_s = time.monotonic() - self._heard_wall
        return wall_s < SILENCE_S or clock.now() - self._heard_ros < SILENCE_S

    def servers(self) -> tuple[str, ...]:
        """Return the names of the nodes that publish statuses and take goals.

        Either alone makes no server: `rosbag record` takes goals, `rosbag play` publishes statuses.
        """
        publishers = sorted(senders(self._subscribers[0]))
        return tuple(name for name in publishers if hears(self._goal_publisher, name))

    def wait(self, limit_s: float) -> bool:
        """Wait for the server, at most `limit_s` [s] of wall time; return whether it is there."""
        start = time.monotonic()
        is_logged = False
        while not self.is_available():
            waited = time.monotonic() - start
            if waited >= limit_s or rospy.is_shutdown() or WAITS.is_stopped():
                return False
            if not is_logged and waited > _LOG_AFTER_S:
                is_logged = True
                WAITS.report(f"waiting up to {limit_s:g} s for action server {self._topic}")
            self._changed.wait(_CHECK_EVERY_S)
            self._changed.clear()
        if is_logged:
            rospy.loginfo("action server %s is there", self._topic)
        return True

    def send(self, goal: Message) -> Goal:
        """Send a goal, given as the goal message of the action."""
        # The wall clock keeps ids apart when simulated time restarts.
        goal_id = f"{rospy.get_name()}-{next(_goal_numbers)}-{time.time():.6f}"
        sent = Goal(goal_id, time.monotonic())
        self._goals[goal_id] = sent
        self.latest = sent
        message = self._goal_type(goal=goal)
        message.header.stamp = message.goal_id.stamp = rospy.Time.now()
        message.goal_id.id = goal_id
        self._goal_publisher.publish(message)
        return sent

    def cancel(self, goal: Goal) -> None:
        """Ask the server to stop working on a goal."""
        self._cancel_publisher.publish(GoalID(id=goal.goal_id))

    def cancel_all(self) -> None:
        """Ask the server to stop working on all goals of this process."""
        for goal in list(self._goals.values()):
            if goal.is_active:
                self.cancel(goal)

    def _is_connected(self) -> bool:
        servers = [senders(subscriber) for subscriber in self._subscribers]
        return any(
            hears(self._goal_publisher, server) and hears(self._cancel_publisher, server)
            for server in set.intersection(*servers)
        )

    def _on_status(self, message: GoalStatusArray) -> None:
        self._heard_wall, self._heard_ros = time.monotonic(), clock.now()
        self._changed.set()
        listed = {status.goal_id.id: status for status in message.status_list}
        goals = list(self._goals.values())
        now = self._heard_wall
        if any([goal.take_status(listed.get(goal.goal_id), now) for goal in goals]):
            self.for_status.wake_all()

    def _on_feedback(self, message: Message) -> None:
        goal = self._goals.get(message.status.goal_id.id)
        if goal is not None and goal.is_active:
            goal.feedback = message.feedback
            self.for_feedback.wake_all()

    def _on_result(self, message: Message) -> None:
        goal = self._goals.get(message.status.goal_id.id)
        if goal is not None and goal.is_active:
            goal.take_result(message.status, message.result)
            for waiting in (self.for_result, self.for_feedback, self.for_status):
                waiting.wake_all()


# One goal at an action server, as its client knows it


_TERMINAL = frozenset(
    {
        GoalStatus.PREEMPTED,
        GoalStatus.SUCCEEDED,
        GoalStatus.ABORTED,
        GoalStatus.REJECTED,
        GoalStatus.RECALLED,
        GoalStatus.LOST,
    }
)

# What a simple client calls the server's intermediate states.
_SIMPLE = {GoalStatus.RECALLING: GoalStatus.PENDING, GoalStatus.PREEMPTING: GoalStatus.ACTIVE}


# [s] A server lists a goal as soon as it has it. A server that publishes its list for this long
# without the goal never received it: the goal was sent into a connection that was about to end.
UNNOTICED_S = 5.0


class Goal:
    """The client's view of a goal.

    Attributes:
        goal_id: its name on the wire.
        sent_at: [s] when it was sent, by time.monotonic.
        status: a constant of GoalStatus.
        text: what the server says about the status.
        result: the server's result, until it is removed.
        feedback: the server's last feedback, until it is removed.
        gone_since: [s] when the server was first found missing; None while it is there.
    """

    def __init__(self, goal_id: str, sent_at: float = 0.0) -> None:
        self.goal_id = goal_id
        self.sent_at = sent_at
        self.status: int = GoalStatus.PENDING
        self.text = ""
        self.result: Message | None = None
        self.feedback: Message | None = None
        self.gone_since: float | None = None
        self._is_known = False

    @property
    def is_active(self) -> bool:
        """Return whether the server may still answer."""
        return self.status not in _TERMINAL

    @property
    def simple_status(self) -> int:
        """Return the status as actionlib's simple client reports it."""
        return _SIMPLE.get(self.status, self.status)

    def take_status(self, listed: GoalStatus | None, now: float = 0.0) -> bool:
        """Take what the server lists about the goal at `now` [s]; None if it lists nothing.

        A goal that the server knew and no longer lists is lost: the server was restarted. A goal
        that it never lists is lost too. A terminal status counts only with its result, which
        arrives on another topic.

        Returns:
            whether the status changed.
        """
        if not self.is_active:
            return False
        if listed is None:
            if not self._is_known and now - self.sent_at < UNNOTICED_S:
                return False
            self.status = GoalStatus.LOST
            self.text = (
                "the server no longer knows the goal; it was restarted"
                if self._is_known
                else "the server never received the goal"
            )
            return True
        self._is_known = True
        if listed.status in _TERMINAL or listed.status == self.status:
            return False
        self.status, self.text = listed.status, listed.text
        return True

    def take_result(self, status: GoalStatus, result: Message) -> None:
        """Take the server's answer."""
        self.status, self.text, self.result = status.status, status.text, result
