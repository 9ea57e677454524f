"""What was heard about one goal, from sending it to the last word about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from actionlib_msgs.msg import GoalStatus

TERMINAL = frozenset(
    {
        GoalStatus.PREEMPTED,
        GoalStatus.SUCCEEDED,
        GoalStatus.ABORTED,
        GoalStatus.REJECTED,
        GoalStatus.RECALLED,
    }
)
STATUS_NAMES = {
    value: name
    for name, value in vars(GoalStatus).items()
    if isinstance(value, int) and name.isupper()
}


@dataclass(frozen=True)
class Feedback:
    """One feedback message.

    Attributes:
        ros_s: [s] ROS time at which it was heard.
        message: the ability's feedback.
    """

    ros_s: float
    message: Any


@dataclass(frozen=True)
class Result:
    """One result message.

    Attributes:
        ros_s: [s] ROS time at which it was heard.
        wall_s: [s] wall time at which it was heard.
        status: constant of GoalStatus that came with it.
        text: what came with the status.
        message: the ability's result.
    """

    ros_s: float
    wall_s: float
    status: int
    text: str
    message: Any

    @property
    def reason(self) -> str:
        """Whatever the server says about a failure."""
        return f"{self.message.error_message} {self.text}".strip()


@dataclass
class Exchange:
    """One goal and what was heard about it. Times are [s] of one clock each, ROS or wall.

    Attributes:
        goal: the ability's goal.
        sent_ros_s: when it was sent.
        active_ros_s: when the server was first heard to work on it.
        listed: whether the server ever listed it in its status.
        cancelled_wall_s: when it was cancelled.
        feedback: all feedback, in order.
        results: all results, in order; a good server sends one.
    """

    goal: Any
    sent_ros_s: float
    active_ros_s: float | None = None
    listed: bool = False
    cancelled_wall_s: float | None = None
    feedback: list[Feedback] = field(default_factory=list)
    results: list[Result] = field(default_factory=list)

    @property
    def result(self) -> Result | None:
        """The first result."""
        return self.results[0] if self.results else None

    @property
    def is_done(self) -> bool:
        """Whether it ended as it was meant to."""
        result = self.result
        return result is not None and result.status == GoalStatus.SUCCEEDED

    @property
    def is_refused(self) -> bool:
        """Whether the server never began to work on it."""
        result = self.result
        return result is not None and result.status in (GoalStatus.REJECTED, GoalStatus.RECALLED)

    @property
    def took_s(self) -> float:
        """How long [s, ROS] from sending to the result; 0 without one."""
        return self.result.ros_s - self.sent_ros_s if self.result else 0.0
