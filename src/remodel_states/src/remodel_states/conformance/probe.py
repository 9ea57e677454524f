"""Send goals to one action server, good and bad ones, and store all messages about each.

It uses actionlib's topics itself: a client of actionlib hides what a faulty server does, such as a
second result.
"""

from __future__ import annotations

import copy
import io
import itertools
import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import genpy
import rospy
import yaml
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from genpy import Message
from roslib.message import get_message_class

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


# The goals that are tried: a good one, and bad ones made from it


# Stands for a name that does not exist.
UNKNOWN_NAME = "no_such_name"

_FLOATS = frozenset({"float32", "float64"})


@dataclass(frozen=True)
class BadGoal:
    """A goal that is invalid in one field.

    Attributes:
        field: the field, as it stands in the goal.
        what: what is wrong with it, in words.
        goal: the goal.
    """

    field: str
    what: str
    goal: Any


def invalid_goals(good: Message) -> Iterator[BadGoal]:
    """Yield goals that a server must refuse before anything moves."""
    for value in (0.0, -1.0, math.inf, math.nan):
        yield BadGoal("timeout", f"timeout {value}", _with(good, "timeout", value))
    yield BadGoal("id", "an empty id", _with(good, "id", ""))
    for name, kind in zip(good.__slots__, good._slot_types, strict=True):
        if name == "timeout":
            continue
        spoilt = copy.deepcopy(good)
        if kind in _FLOATS:
            setattr(spoilt, name, math.nan)
            yield BadGoal(name, f"{name} NaN", spoilt)
        elif _spoil(getattr(spoilt, name)):
            yield BadGoal(name, f"{name} with NaN", spoilt)


def goals_with_unknown_names(good: Message) -> Iterator[BadGoal]:
    """Yield goals about things that do not exist: whatever a server does, they cannot succeed."""
    for name in _names(good):
        if getattr(good, name):
            yield BadGoal(name, f"{name} {UNKNOWN_NAME!r}", _with(good, name, UNKNOWN_NAME))


def names_left_empty(good: Message) -> list[str]:
    """Return the fields of names that are empty in a goal, so that no other name is tried."""
    return [name for name in _names(good) if not getattr(good, name)]


def _names(goal: Message) -> list[str]:
    kinds = zip(goal.__slots__, goal._slot_types, strict=True)
    return [name for name, kind in kinds if kind == "string" and name != "id"]


def _with(good: Message, name: str, value: object) -> Message:
    goal = copy.deepcopy(good)
    setattr(goal, name, value)
    return goal


def _spoil(value: object) -> bool:
    """Make every number inside a message NaN; return whether there was one."""
    if isinstance(value, list):
        return any([_spoil(item) for item in value])
    if not isinstance(value, Message):
        return False
    found = False
    for name, kind in zip(value.__slots__, value._slot_types, strict=True):
        if kind in _FLOATS:
            setattr(value, name, math.nan)
            found = True
        else:
            found = _spoil(getattr(value, name)) or found
    return found


# Read the goal that a server is tried with


# [s] Timeout of a goal that names none.
TIMEOUT_S = 60.0

ID = "conformance"


class GoalError(Exception):
    """The goal cannot be read; the text says where, what was found and what to do."""


def action_class(name: str) -> type[Message]:
    """Return the class of an action.

    Args:
        name: such as `DetectCable` (of remodel_msgs) or `package/Name`, with or without Action.

    Raises:
        GoalError: if there is no such action, or the messages of its package cannot be imported.
    """
    kind = name if "/" in name else f"remodel_msgs/{name}"
    kind = f"{kind.removesuffix('Action')}Action"
    try:
        found = get_message_class(kind)
    except Exception as error:
        raise GoalError(f"cannot load {kind}: {type(error).__name__}: {error}") from error
    if found is None or not hasattr(found, "_type") or "action_goal" not in found.__slots__:
        raise GoalError(
            f"there is no action {kind.removesuffix('Action')}; give one of another package as "
            "package/Name. `rosmsg list` lists the types, and those of actions end in Action. The "
            "package must be built, and its setup.bash sourced"
        )
    return found


def read_goal(action_type: type[Message], text: str) -> Any:  # noqa: ANN401 - any ability's goal
    """Return the goal of an action, with id and timeout.

    Args:
        action_type: `...Action` class.
        text: YAML mapping of the goal's fields, or the name of a file that holds one.

    Raises:
        GoalError: if it is not such a mapping, or the action has no id or no timeout.
    """
    is_file = text.endswith((".yaml", ".yml"))
    try:
        fields = yaml.safe_load(Path(text).read_text(encoding="utf-8") if is_file else text)
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise GoalError(f"cannot read the goal: {error}") from error
    if not isinstance(fields, dict):
        raise GoalError(f"a goal is a YAML mapping such as '{{cable_id: W1}}', found {text!r}")
    goal = type(action_type().action_goal.goal)()
    lacking = [name for name in ("id", "timeout") if name not in goal.__slots__]
    if lacking:
        raise GoalError(
            f"a goal of {action_type._type} has no {' and no '.join(lacking)}; goals of abilities "
            "have both (Deliverable 5.1, 3.1)"
        )
    try:
        genpy.message.fill_message_args(goal, [{"id": ID, "timeout": TIMEOUT_S, **fields}])
        goal.serialize(io.BytesIO())  # which checks the types
    except (genpy.MessageException, ValueError, TypeError, AttributeError) as error:
        raise GoalError(f"the goal does not fit {action_type._type}: {error}") from error
    return goal
