"""What ability states reach the world by: ROS, or what stands for it in the same process.

A state takes the line that is in force when it is made. `by_line` puts another one in force, so
that the very same behaviors run where there is no ROS master, such as in rehearsals.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from genpy import Message
from remodel_msgs.msg import AbilityRecord
from remodel_msgs.srv import BeginOperationRequest

from flexbe_core import Logger
from flexbe_core.proxy import ProxyActionClient, ProxyPublisher
from remodel_states.record_keeping import Keeping, Permit, Request, keeper, recorder

RECORD_TOPIC = "remodel/ability_records"


class Client(Protocol):
    """An action client, as FlexBE's proxy has it; the topic is that of the server."""

    def send_goal(self, topic: str, goal: Message) -> None:
        """Send a goal; raises if there is no server."""

    def is_available(self, topic: str) -> bool:
        """Return whether the server is there."""

    def has_result(self, topic: str) -> bool:
        """Return whether the server has answered."""

    def get_result(self, topic: str) -> Message | None:
        """Return the answer; None if there is none."""

    def get_state(self, topic: str) -> int:
        """Return the status of the goal, of actionlib_msgs/GoalStatus."""

    def get_goal_status_text(self, topic: str) -> str:
        """Return what the server says about the goal."""

    def cancel(self, topic: str) -> None:
        """Ask the server to end the goal."""


class Keeper(Protocol):
    """Asks a supervisor, and has it keep records; see RecordKeeper."""

    def ask(self, operation: BeginOperationRequest, recorder: str, trouble: str = "") -> Permit:
        """Begin to ask whether a goal may be sent."""

    def keep(self, record: AbilityRecord, recorder: str) -> Keeping:
        """Begin to have a record kept."""

    def withdraw(self, request: Request) -> None:
        """Wait no longer."""

    def give_back(self, permit: Permit, unsent: AbilityRecord) -> None:
        """Do not send the goal."""


class Line(Protocol):
    """The world of ability states."""

    def client(self, topic: str, action_type: type[Message]) -> Client:
        """Connect to the server of an ability."""

    def recorder(self) -> str:
        """Return the name of the supervisor's service for records; empty without a supervisor."""

    def keeper(self) -> Keeper:
        """Return what asks that supervisor."""

    def publish(self, record: AbilityRecord) -> None:
        """Publish the record of an ability that has ended."""

    def warn(self, text: str) -> None:
        """Warn operators."""


class RosLine:
    """The line over ROS."""

    def client(self, topic: str, action_type: type[Message]) -> Client:
        """Connect to an action server; stock FlexBE's proxies warn if it is not there."""
        ProxyPublisher({RECORD_TOPIC: AbilityRecord})
        client: Client = ProxyActionClient({topic: action_type})
        return client

    def recorder(self) -> str:
        """Ask the ROS master."""
        return recorder()

    def keeper(self) -> Keeper:
        """Return the process's."""
        return keeper()

    def publish(self, record: AbilityRecord) -> None:
        """Publish it."""
        ProxyPublisher().publish(RECORD_TOPIC, record)

    def warn(self, text: str) -> None:
        """Log it, at the console too."""
        Logger.logwarn(text)


_in_force: list[Line] = [RosLine()]


def line() -> Line:
    """Return the line that is in force."""
    return _in_force[-1]


@contextmanager
def by_line(other: Line) -> Iterator[None]:
    """Put another line in force for the states that are made meanwhile."""
    _in_force.append(other)
    try:
        yield
    finally:
        _in_force.remove(other)
