"""Send goals to one action server and store all messages about each.

It uses actionlib's topics itself: a client of actionlib hides what a faulty server does, such as a
second result.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from genpy import Message

from remodel_states.conformance.rules import Exchange, Feedback, Result

# [s] Wall time between two checks of ROS time, which may be simulated.
_CHECK_EVERY_S = 0.05

_WORKED_ON = (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)


class Probe:
    """The connection to one action server."""

    def __init__(self, topic: str, action_type: type[Message]) -> None:
        """Connect to the server at `topic`."""
        action = action_type()
        self._action_goal_type = type(action.action_goal)
        self._numbers = itertools.count(1)
        self._exchanges: dict[str, Exchange] = {}
        self._changed = threading.Condition()
        self._goals = rospy.Publisher(f"{topic}/goal", self._action_goal_type, queue_size=10)
        self._cancels = rospy.Publisher(f"{topic}/cancel", GoalID, queue_size=10)
        self._subscribers = [
            rospy.Subscriber(f"{topic}/{name}", kind, callback, tcp_nodelay=True)
            for name, kind, callback in (
                ("status", GoalStatusArray, self._on_status),
                ("feedback", type(action.action_feedback), self._on_feedback),
                ("result", type(action.action_result), self._on_result),
            )
        ]

    def close(self) -> None:
        """End the connections."""
        for connection in (*self._subscribers, self._goals, self._cancels):
            connection.unregister()

    def missing(self) -> list[str]:
        """Return the topics of the action on which no server is connected, without their prefix."""
        connections = {
            "goal": self._goals.get_num_connections(),
            "cancel": self._cancels.get_num_connections(),
            **{s.name.rpartition("/")[2]: _established(s) for s in self._subscribers},
        }
        return [name for name, count in connections.items() if not count]

    def wait_for_server(self, limit_s: float) -> bool:
        """Wait until a server is connected and there is a time; return whether it is.

        Args:
            limit_s: [s] wall time to wait at most.
        """
        end = time.monotonic() + limit_s
        while self.missing() or rospy.Time.now().is_zero():
            if time.monotonic() > end or rospy.is_shutdown():
                return False
            time.sleep(_CHECK_EVERY_S)
        return True

    def send(self, goal: Message) -> Exchange:
        """Send a goal."""
        goal_id = f"{rospy.get_name()}-{id(self)}-{next(self._numbers)}"
        now = rospy.Time.now()
        exchange = Exchange(goal, now.to_sec())
        self._exchanges[goal_id] = exchange
        message = self._action_goal_type(goal=goal, goal_id=GoalID(now, goal_id))
        message.header.stamp = now
        self._goals.publish(message)
        return exchange

    def cancel(self, exchange: Exchange) -> None:
        """Cancel a goal."""
        exchange.cancelled_wall_s = time.monotonic()
        self._cancels.publish(GoalID(id=self._id_of(exchange)))

    def cancel_unknown_goal(self) -> None:
        """Cancel a goal that was never sent."""
        self._cancels.publish(GoalID(id="this goal was never sent"))

    def wait(self, condition: Callable[[], bool], limit_s: float) -> bool:
        """Wait until a message makes the condition true; return whether it is.

        Args:
            condition: checked after each message.
            limit_s: [s] ROS time to wait at most.
        """
        end = rospy.Time.now().to_sec() + limit_s
        with self._changed:
            while not condition() and rospy.Time.now().to_sec() < end:
                if rospy.is_shutdown():
                    raise rospy.ROSInterruptException("ROS was shut down during a trial")
                self._changed.wait(_CHECK_EVERY_S)
            return condition()

    def _id_of(self, exchange: Exchange) -> str:
        return next(key for key, value in self._exchanges.items() if value is exchange)

    def _on_status(self, message: GoalStatusArray) -> None:
        with self._changed:
            for status in message.status_list:
                exchange = self._exchanges.get(status.goal_id.id)
                if exchange is not None:
                    exchange.listed = True
                    if status.status in _WORKED_ON and exchange.active_ros_s is None:
                        exchange.active_ros_s = rospy.Time.now().to_sec()
            self._changed.notify_all()

    def _on_feedback(self, message: Message) -> None:
        with self._changed:
            exchange = self._exchanges.get(message.status.goal_id.id)
            if exchange is not None:
                exchange.feedback.append(Feedback(rospy.Time.now().to_sec(), message.feedback))
            self._changed.notify_all()

    def _on_result(self, message: Message) -> None:
        with self._changed:
            exchange = self._exchanges.get(message.status.goal_id.id)
            if exchange is not None:
                exchange.results.append(
                    Result(
                        rospy.Time.now().to_sec(),
                        time.monotonic(),
                        message.status.status,
                        message.status.text,
                        message=message.result,
                    )
                )
            self._changed.notify_all()


def _established(subscriber: rospy.Subscriber) -> int:
    """Return how many nodes the subscriber hears; rospy counts also those it is still calling."""
    return sum(c.callerid_pub != "unknown" for c in subscriber.impl.connections)
