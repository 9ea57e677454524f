"""What ability servers are made of: running and invalid goals, and who may command a robot."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import rospy
from actionlib import ServerGoalHandle
from genpy import Message
from remodel_msgs.msg import ErrorCode
from roslib.message import get_message_class

from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import CLOCKS_DIFFER_S, LATE_S, RosStopwatch
from remodel_states.core.tables import Ability, TableError

# A goal that an ability server has accepted: its feedback, its limits and its end


# [s] Wall time between two feedbacks at least, and while `wait` is called, at most.
_QUIET_S = 0.1
_FEEDBACK_S = 0.5

# [s] Wall time between two readings of the clock.
_POLL_S = 0.02


class StoppedError(AbilityError):
    """The goal was cancelled, or its timeout has passed."""


class RunningGoal:
    """One goal of an ability.

    A goal ends once, by `succeed` or `fail`. Servers whose ability is a function
    (`AbilityServer.perform`) call neither: they return, or raise an AbilityError.

    Attributes:
        goal: the message.
    """

    def __init__(
        self, ability: Ability, handle: ServerGoalHandle, elapsed: Callable[[], float] | None = None
    ) -> None:
        """Begin.

        Args:
            ability: whose goal it is.
            handle: the action server's.
            elapsed: returns the ROS time [s] since now; `/clock` by default.
        """
        self.goal: Message = handle.get_goal()
        self._handle = handle
        self._result = message_class(ability, "Result")
        self._feedback = message_class(ability, "Feedback")
        self._elapsed = (
            elapsed or RosStopwatch(lambda: rospy.Time.now().to_sec(), time.monotonic).read
        )
        self._cancelled = threading.Event()
        self._latest = ("", 0.0)
        self._reported_s = 0.0

    @property
    def elapsed_s(self) -> float:
        """How long it has taken: [s] ROS time."""
        return self._elapsed()

    @property
    def is_cancelled(self) -> bool:
        """Whether a client asked to cancel it."""
        return self._cancelled.is_set()

    def is_cancelled_within(self, seconds: float) -> bool:
        """Wait for a cancel, [s] wall time, and return whether one came."""
        return self._cancelled.wait(None if seconds == math.inf else seconds)

    def cancel(self) -> None:
        """Ask the ability to stop; from any thread."""
        self._cancelled.set()

    def report(self, message: str, percentage: float) -> None:
        """Publish feedback.

        Args:
            message: the step that is being done, for a person.
            percentage: [%] of the whole, 0 to 100; a smaller one than before has no effect.
        """
        share = max(self._latest[1], min(percentage, 100.0))
        self._latest = (message, share)
        if share == 100.0 or time.monotonic() - self._reported_s >= _QUIET_S:
            self._publish()

    def check(self) -> None:
        """Return if the ability may continue.

        Raises:
            StoppedError: if the goal is cancelled, or its timeout has passed.
        """
        elapsed_s = self.elapsed_s
        if self.is_cancelled:
            text = f"cancelled after {elapsed_s:.1f} s; the robot stopped"
            raise StoppedError(ErrorCode.PREEMPTED, text)
        if elapsed_s >= self.goal.timeout:
            text = f"not done within {self.goal.timeout:g} s: {self._latest[0]}"
            raise StoppedError(ErrorCode.TIMEOUT, text)

    def wait(self, seconds: float) -> None:
        """Wait, and repeat the latest feedback meanwhile.

        Args:
            seconds: [s] ROS time.

        Raises:
            StoppedError: if the goal is cancelled, or its timeout passes.
        """
        end_s = self.elapsed_s + seconds
        while True:
            self.check()
            if time.monotonic() - self._reported_s >= _FEEDBACK_S:
                self._publish()
            if self.elapsed_s >= end_s:
                return
            self._cancelled.wait(_POLL_S)

    def succeed(self, message: str, found: Mapping[str, Any]) -> None:
        """End it as done.

        Args:
            message: what was done, for a person.
            found: fields of the result.
        """
        if self._latest != (message, 100.0):
            self.report(message, 100.0)
        result = self._result(id=self.goal.id, success=True, message=message)
        self._handle.set_succeeded(self._filled(result, found), message)

    def fail(self, code: int, text: str, found: Mapping[str, Any], message: str = "") -> None:
        """End it as not done.

        Args:
            code: number of the error code; PREEMPTED ends it as cancelled.
            text: what was asked, found, and what to do.
            found: fields of the result. Those that it does not have are left out: they are of
                another ability, of which this one made use.
            message: short, for a person.
        """
        result = self._result(
            id=self.goal.id, message=message, error_code=int(code), error_message=text
        )
        is_cancelled = code == ErrorCode.PREEMPTED
        end = self._handle.set_canceled if is_cancelled else self._handle.set_aborted
        own = {name: value for name, value in found.items() if name in result.__slots__}
        end(self._filled(result, own), text)

    def _filled(self, result: Message, found: Mapping[str, Any]) -> Message:
        result.elapsed_time = self.elapsed_s
        for name, value in found.items():
            setattr(result, name, value)
        return result

    def _publish(self) -> None:
        message, share = self._latest
        self._reported_s = time.monotonic()
        feedback = self._feedback(self.goal.id, message, self.elapsed_s, share)
        self._handle.publish_feedback(feedback)


# Goals that are invalid, whatever the ability


def why_invalid(goal: Message) -> str:
    """Return why a goal is invalid; empty if it is valid."""
    if not goal.id:
        return "id is empty; it must name the goal"
    if not 0 < goal.timeout < math.inf:
        return f"timeout must be a positive number, found {goal.timeout}"
    for name in goal.__slots__:
        if any(not math.isfinite(number) for number in _numbers(getattr(goal, name))):
            return f"{name} holds NaN or infinity"
    return ""


def why_late(sent_s: float, now_s: float, timeout_s: float) -> str:
    """Return why a goal has arrived too late to begin; empty if it has not.

    Args:
        sent_s: [s] ROS time of the goal's id; 0 if its client gave none.
        now_s: [s] ROS time.
        timeout_s: [s] of the goal.
    """
    late_s, most_s = now_s - sent_s, min(timeout_s, LATE_S) + CLOCKS_DIFFER_S
    if not sent_s or late_s <= most_s:
        return ""
    return (
        f"sent {late_s:.1f} s ago, so its client has given it up; allowed: {most_s:g} s. The "
        "server was stalled, or the clocks of the two machines differ"
    )


def _numbers(value: object) -> Iterator[float]:
    """Yield the floating-point numbers in a field of a message, however deep."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _numbers(item)
    elif isinstance(value, Message):
        for name in value.__slots__:
            yield from _numbers(getattr(value, name))


# What the ability servers of one robot share


class Robot:
    """A robot does one goal at a time, over all its abilities, for the newest supervisor."""

    def __init__(self, name: str = "the robot") -> None:
        """Name it, for messages."""
        self._name = name
        self._lock = threading.Lock()
        self._is_busy = False
        self._owners: dict[str, int] = {}

    def begin(self, owner: int) -> None:
        """Begin a goal.

        Args:
            owner: token of the supervisor that sent it (`owner_of`); 0 is not checked.

        Raises:
            AbilityError: BUSY while it does another goal, STALE_OWNER after a newer supervisor.
        """
        with self._lock:
            if self._is_busy:
                text = f"{self._name} is doing another goal; wait for it or cancel it"
                raise AbilityError(ErrorCode.BUSY, text)
            self._owners = admitted(self._owners, self._name, owner)
            self._is_busy = True

    def end(self) -> None:
        """End the goal."""
        with self._lock:
            self._is_busy = False


# Which supervisor may command a cell: the one with the newest token.
#
# A token is a number that grows whenever a supervisor takes a cell over. It is in front of a goal's
# id, such as "17:Connect/Insert#1", and a field of the cell's services. Who shows no token is not
# checked.


def admitted(owners: Mapping[str, int], cell: str, token: int) -> dict[str, int]:
    """Return the newest token of each cell, after one was shown to a cell.

    Raises:
        AbilityError: STALE_OWNER if the cell has seen a newer one.
    """
    newest = owners.get(cell, 0)
    if 0 < token < newest:
        raise AbilityError(
            ErrorCode.STALE_OWNER,
            f"supervisor {token} no longer owns {cell}: supervisor {newest} does. Stop the older "
            "one, or give each cell a name of its own",
        )
    return {**owners, cell: token} if token > newest else dict(owners)


# The messages of an ability's action


def message_class(ability: Ability, part: str) -> type[Message]:
    """Return a class such as InsertCableResult.

    Args:
        ability: whose action it is.
        part: "Action", "Goal", "Result", "Feedback", "ActionGoal" and so on.

    Raises:
        TableError: if the package of the ability is not built or sourced.
    """
    found = get_message_class(f"{ability.package}/{ability.name}{part}")
    if found is None:
        problem = f"{ability.name}: its messages are not built; build and source its workspace"
        raise TableError(ability.package, [problem])
    return found
