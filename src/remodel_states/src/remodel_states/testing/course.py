"""The course of a fake operation in time."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from random import Random

from remodel_msgs.msg import ErrorCode

from remodel_states.serving.running_goal import RunningGoal, StoppedError

# [s] Wall time between two feedbacks.
_FEEDBACK_S = 0.2


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


class CourseOfGoal:
    """The course of a goal that begins now; its timeout is taken as wall time too."""

    def __init__(self, running: RunningGoal, course: Course) -> None:
        """Begin."""
        self._running = running
        self._course = course
        self._began = time.monotonic()

    def wait_until(self, at_s: float) -> None:
        """Wait until a time of the course [s], and report progress.

        Raises:
            StoppedError: if the goal is cancelled, or its timeout passes.
        """
        timeout_s = self._running.goal.timeout
        until = self._began + min(at_s, timeout_s)
        while (left := until - time.monotonic()) > 0:
            self._wait(min(left, _FEEDBACK_S))
            share = 100.0 * min(1.0, (time.monotonic() - self._began) / self._course.end_s)
            self._running.report(f"by a fake: {share:.0f} %", share)
        if at_s > timeout_s:
            raise StoppedError(ErrorCode.TIMEOUT, f"not done within {timeout_s:g} s")

    def hang(self) -> None:
        """Wait for a cancel, whatever the timeout."""
        self._wait(math.inf)

    def _wait(self, seconds: float) -> None:
        if self._running.is_cancelled_within(seconds):
            raise StoppedError(ErrorCode.PREEMPTED, "cancelled; the arm stopped")
