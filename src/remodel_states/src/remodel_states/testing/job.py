"""One goal being done by a fake ability: its course in time, and its end."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from random import Random

import actionlib
import rospy
from genpy import Message
from remodel_msgs.msg import ErrorCode

from remodel_states.testing.faults import Fault

# [s] Wall time between two feedbacks.
_TELL_EVERY_S = 0.2


class Stopped(Exception):  # noqa: N818 - a way to end, not always an error
    """The goal ends undone."""

    def __init__(self, code: int, text: str) -> None:
        """Tell a remodel_msgs/ErrorCode, and why."""
        super().__init__(text)
        self.code = code


@dataclass(frozen=True)
class Course:
    """When an operation takes effect, and when it ends: [s] wall time from its start."""

    effect_s: float
    end_s: float

    @classmethod
    def drawn(cls, random: Random, mean_s: float) -> Course:
        """Draw a course: a little shorter or longer than usual, the effect anywhere in it."""
        end_s = mean_s * random.uniform(0.5, 1.5)
        return cls(random.uniform(0.0, end_s), end_s)


class Job:
    """A goal that was accepted.

    Attributes:
        goal: as it was sent.
        handle: the server's.
        fault: that strikes it; None for none.
        random: for this goal only.
        course: see Course.
    """

    def __init__(
        self,
        handle: actionlib.ServerGoalHandle,
        feedback: type[Message],
        fault: Fault | None,
        random: Random,
        mean_s: float,
    ) -> None:
        """Begin."""
        self.goal = handle.get_goal()
        self.handle = handle
        self.fault = fault
        self.random = random
        self.course = Course.drawn(random, mean_s)
        self._feedback = feedback
        self._began = time.monotonic()
        self._began_ros = rospy.Time.now()
        self._cancelled = threading.Event()

    @property
    def elapsed_s(self) -> float:
        """How long it has taken: [s] ROS time."""
        return (rospy.Time.now() - self._began_ros).to_sec()

    def cancel(self) -> None:
        """Have the job stop where it is; from any thread."""
        self._cancelled.set()

    def wait_until(self, at_s: float) -> None:
        """Wait until a time of the course [s], telling how far it is.

        Raises:
            Stopped: if it is cancelled, or its timeout passes.
        """
        until = self._began + min(at_s, self.goal.timeout)
        while (left := until - time.monotonic()) > 0:
            if self._cancelled.wait(min(left, _TELL_EVERY_S)):
                raise Stopped(ErrorCode.PREEMPTED, "cancelled; the arm stands still")
            self.tell(100.0 * min(1.0, (time.monotonic() - self._began) / self.course.end_s))
        if at_s > self.goal.timeout:
            raise Stopped(ErrorCode.TIMEOUT, f"not done within {self.goal.timeout:g} s")

    def hang(self) -> None:
        """Wait for a cancel, whatever the timeout."""
        self._cancelled.wait()
        raise Stopped(ErrorCode.PREEMPTED, "cancelled; the arm stands still")

    def tell(self, percentage: float) -> None:
        """Publish feedback: [%] of the course."""
        text = f"by a fake: {percentage:.0f} %"
        self.handle.publish_feedback(self._feedback(self.goal.id, text, self.elapsed_s, percentage))
