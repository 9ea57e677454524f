"""One goal being done."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Sequence

import rospy
from actionlib import ServerGoalHandle
from genpy import Message

from remodel_sim.abilities.runner import occupy
from remodel_sim.abilities.station import Found, Station
from remodel_sim.core.errors import AbilityError, MemoryFileError
from remodel_sim.core.goals import Goal
from remodel_sim.ros.abilities import Ability
from remodel_sim.ros.conversions import observation, result_value
from remodel_states.core.codes import Code

FEEDBACK_PERIOD_S = 0.1  # of wall time


class Job:
    """An accepted goal, its steps and its end; all in the owner's thread but `cancel`.

    Attributes:
        robots: that do it; the first one's progress is told.
    """

    def __init__(
        self,
        ability: Ability,
        goal: Goal,
        handle: ServerGoalHandle,
        stations: Sequence[Station],
        now_s: float,
        keep: Callable[[], None],
    ) -> None:
        """Begin a goal that has been accepted, with the robots that it needs.

        `keep` stores what the goal has changed in the cell; raises MemoryFileError. It is called
        before the result is sent: what a client has read in a result must outlive this process.
        """
        self.robots = tuple(station.name for station in stations)
        self._ability = ability
        self._message = handle.get_goal()
        self._handle = handle
        self._started_s = now_s
        self._keep = keep
        self._cancelled = False
        self._told = 0.0
        self._stations = stations
        self._steps = occupy(stations, ability.perform(*stations, goal))

    def __str__(self) -> str:
        """Name the ability and its goal."""
        return f"{self._ability.name} (goal {self._message.id!r})"

    @property
    def handle(self) -> ServerGoalHandle:
        """The goal's handle."""
        return self._handle

    def cancel(self) -> None:
        """Ask the job to stop; it does before the next tick."""
        self._cancelled = True

    def stop(self) -> None:
        """Leave the steps where they are; the arms stay where they were sent."""
        self._steps.close()

    def step(self, now_s: float) -> bool:
        """Do the next step; returns whether the goal has come to its end."""
        elapsed = now_s - self._started_s
        if self._cancelled:
            self._end(
                Code.PREEMPTED, f"cancelled after {elapsed:.1f} s; the arm stands still", elapsed
            )
            return True
        if elapsed > self._message.timeout:
            text = (
                f"not done within {self._message.timeout:g} s: {self._stations[0].progress.message}"
            )
            self._end(Code.TIMEOUT, text, elapsed)
            return True
        try:
            next(self._steps)
        except StopIteration as done:
            self._succeed(done.value, elapsed)
            return True
        except AbilityError as error:
            self._end(error.code, str(error), elapsed, error.readings)
            return True
        except Exception as error:  # noqa: BLE001 - a goal must end whatever happens
            rospy.logerr("%s: %s", self, traceback.format_exc())
            self._end(Code.INTERNAL, f"{type(error).__name__}: {error}; the log has more", elapsed)
            return True
        self._tell(elapsed)
        return False

    def _tell(self, elapsed: float) -> None:
        wall = time.monotonic()
        if wall - self._told < FEEDBACK_PERIOD_S:
            return
        self._told = wall
        progress = self._stations[0].progress
        feedback = self._ability.message("Feedback")(
            self._message.id, progress.message, elapsed, 100.0 * progress.share
        )
        self._handle.publish_feedback(feedback)

    def _succeed(self, found: Found, elapsed: float) -> None:
        try:
            self._keep()
        except MemoryFileError as error:
            self._end(Code.INTERNAL, f"{found.message}, but it is not kept: {error}", elapsed)
            return
        result = common_result(self._ability, self._message.id, elapsed)
        result.success, result.message = True, found.message
        if self._ability.name == "DetectCable":
            result.observation = observation(found, self._message.cable_id)
        else:
            for name in set(vars(found)) - {"message"}:
                if vars(found)[name] is not None:
                    setattr(result, name, result_value(vars(found)[name]))
        self._handle.publish_feedback(
            self._ability.message("Feedback")(self._message.id, found.message, elapsed, 100.0)
        )
        rospy.loginfo("%s: %s (%.1f s)", self, found.message, elapsed)
        self._handle.set_succeeded(result, found.message)

    def _end(
        self, code: Code, text: str, elapsed: float, readings: dict[str, float] | None = None
    ) -> None:
        self.stop()
        try:
            self._keep()
        except MemoryFileError as error:
            rospy.logerr("%s: %s", self, error)
        result = common_result(self._ability, self._message.id, elapsed)
        result.message = f"{self._ability.name}: {code.name}"
        result.error_code, result.error_message = int(code), text
        for name, value in (readings or {}).items():
            setattr(result, name, value)
        rospy.loginfo("%s: %s: %s (%.1f s)", self, code.name, text, elapsed)
        if code is Code.PREEMPTED:
            self._handle.set_canceled(result, text)
        else:
            self._handle.set_aborted(result, text)


def common_result(ability: Ability, goal_id: str, elapsed: float) -> Message:
    """Return a result with the fields that all abilities share."""
    result = ability.message("Result")()
    result.id, result.elapsed_time = goal_id, elapsed
    return result
