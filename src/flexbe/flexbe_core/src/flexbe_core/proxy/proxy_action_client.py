"""Send goals from a state."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import ClassVar

import rospy
from actionlib_msgs.msg import GoalStatus
from genpy import Message

from flexbe_core.proxy.action_connection import WAITS, ActionConnection, Goal

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
