"""Send goals from a state: a goal as its client knows it, the connection to a server, the proxy."""

from __future__ import annotations

import itertools
import threading
import time
import weakref
from collections.abc import Callable, Mapping
from typing import ClassVar

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
        for goal in self._known_goals():
            if goal.is_active:
                self.cancel(goal)

    def _known_goals(self) -> list[Goal]:
        """Return the goals that are still in use; another thread may send one meanwhile."""
        return [goal for known in self._goals.valuerefs() if (goal := known()) is not None]

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
        goals, now = self._known_goals(), self._heard_wall
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


# [s] How long send_goal waits for a server that was not there at set-up.
_RETRY_S = 1.0

# [s] A state that asks is_available notices a lost server by itself. A state that still asks for
# the result of a lost goal after this long would do so forever.
LOST_GRACE_S = 1.0


class ActionServerLostError(Exception):
    """The server of an active goal is gone, so that its result can never arrive."""


class ProxyActionClient:
    """A handle on the action clients of the process; goals belong to the proxy that sent them."""

    _connections: ClassVar[dict[str, ActionConnection]] = {}

    def __init__(
        self, topics: Mapping[str, type[Message]] | None = None, wait_duration: float = 10
    ) -> None:
        self._goals: dict[str, Goal] = {}
        for topic, action_type in (topics or {}).items():
            self.setupClient(topic, action_type, wait_duration)

    def setupClient(  # noqa: N802 - stock FlexBE's name
        self, topic: str, action_type: type[Message], wait_duration: float = 10
    ) -> None:
        """Connect to a server, unless the process did already.

        Args:
            topic: action topic.
            action_type: `...Action` message.
            wait_duration: [s] wall time to wait for the server; after that, an error is logged,
                and the connection is made when the server starts.
        """
        if topic in self._connections:
            return
        connection = self._connections[topic] = ActionConnection(topic, action_type)
        if not connection.wait(wait_duration) and not WAITS.is_stopped():
            rospy.logerr("action server %s is not there after %g s", topic, wait_duration)

    def send_goal(self, topic: str, goal: Message) -> None:
        """Send a goal; the result and feedback of the last one are forgotten.

        Raises:
            ValueError: if the server is not there.
        """
        connection = self._connections.get(topic)
        if connection is None:
            raise ValueError(f"cannot send a goal to {topic}: no client was set up for it")
        if not connection.wait(_RETRY_S):
            raise ValueError(f"cannot send a goal to {topic}: the action server is not there")
        self._goals[topic] = connection.send(goal)

    def is_available(self, topic: str) -> bool:
        """Return at once whether the server is there and alive, also during a goal.

        After a restart the server is there, but the goal is lost: for LOST_GRACE_S the answer is
        False.
        """
        connection = self._connections.get(topic)
        if connection is None or not connection.is_available():
            return False
        goal = self._goals.get(topic)
        return goal is None or goal.status != GoalStatus.LOST or _gone_for(goal) > LOST_GRACE_S

    def servers(self, topic: str) -> tuple[str, ...]:
        """Return the names of the nodes that take goals at a topic; each executes every goal."""
        return self._connections[topic].servers()

    def has_result(self, topic: str) -> bool:
        """Return whether the server has answered.

        Raises:
            ActionServerLostError: if the server has been gone for LOST_GRACE_S.
        """
        connection = self._connections[topic]
        connection.for_result.add_caller()
        goal = self._goal(topic)
        if goal is None:
            return False
        if goal.result is None and (goal.is_active or goal.status == GoalStatus.LOST):
            self._watch(topic, goal)
        return goal.result is not None

    def get_result(self, topic: str) -> Message | None:
        """Return the server's answer; None if there is none."""
        self._connections[topic].for_result.add_caller()
        goal = self._goal(topic)
        return goal.result if goal else None

    def remove_result(self, topic: str) -> None:
        """Forget the server's answer."""
        goal = self._goal(topic)
        if goal is not None:
            goal.result = None

    def has_feedback(self, topic: str) -> bool:
        """Return whether there is feedback."""
        return self.get_feedback(topic) is not None

    def get_feedback(self, topic: str) -> Message | None:
        """Return the last feedback; None if there is none."""
        self._connections[topic].for_feedback.add_caller()
        goal = self._goal(topic)
        return goal.feedback if goal else None

    def remove_feedback(self, topic: str) -> None:
        """Forget the last feedback."""
        goal = self._goal(topic)
        if goal is not None:
            goal.feedback = None

    def get_state(self, topic: str) -> int:
        """Return the status of the goal, a constant of GoalStatus; LOST if there is no goal."""
        self._connections[topic].for_status.add_caller()
        goal = self._goal(topic)
        return goal.simple_status if goal else GoalStatus.LOST

    def get_goal_status_text(self, topic: str) -> str:
        """Return what the server says about the goal."""
        goal = self._goal(topic)
        return goal.text if goal else ""

    def is_active(self, topic: str) -> bool:
        """Return whether the goal is pending or active."""
        return self.get_state(topic) in (GoalStatus.PENDING, GoalStatus.ACTIVE)

    def cancel(self, topic: str) -> None:
        """Ask the server to stop working on the goal, unless it has answered.

        A lost goal is cancelled too: a server that gets it late, after all, recalls it then.
        """
        goal = self._goal(topic)
        if goal is not None and (goal.is_active or goal.status == GoalStatus.LOST):
            self._connections[topic].cancel(goal)

    def _goal(self, topic: str) -> Goal | None:
        """Return the goal that this proxy sent, or else the last one that the process sent."""
        return self._goals.get(topic) or self._connections[topic].latest

    def _watch(self, topic: str, goal: Goal) -> None:
        if goal.status != GoalStatus.LOST and self._connections[topic].is_available():
            goal.gone_since = None
        elif _gone_for(goal) > LOST_GRACE_S:
            raise ActionServerLostError(
                f"action server {topic} stopped during a goal; its result will never arrive"
            )


def cancel_all_goals() -> None:
    """Ask all servers to stop working on what this process asked for."""
    for connection in tuple(ProxyActionClient._connections.values()):
        connection.cancel_all()


def _gone_for(goal: Goal) -> float:
    """Return how long [s] the goal's server has been known to be missing."""
    if goal.gone_since is None:
        goal.gone_since = time.monotonic()
    return time.monotonic() - goal.gone_since
