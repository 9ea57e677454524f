"""One goal being done."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import rospy

from remodel_skills.abilities.ability import CellAbility
from remodel_skills.goals import Goal
from remodel_skills.robot_context import AbilityResult, RobotContext
from remodel_skills.ros.results import result_fields
from remodel_skills.runner import occupy
from remodel_states.core.ability_error import AbilityError
from remodel_states.core.codes import Code
from remodel_states.serving import RunningGoal
from remodel_work.errors import MemoryFileError


class Job:
    """An accepted goal, its steps and its end; all in the owner's thread.

    Attributes:
        robots: that do it; the progress of the one that is furthest is reported.
    """

    def __init__(
        self,
        ability: CellAbility,
        running: RunningGoal,
        contexts: Sequence[RobotContext],
        goal: Goal,
        keep: Callable[[], None],
        finish: Callable[[Callable[[], None]], None],
    ) -> None:
        """Begin a goal.

        Args:
            ability: its steps.
            running: the goal as its client sees it.
            contexts: the robots that it needs.
            goal: what to do.
            keep: stores what the goal has changed in the cell; raises MemoryFileError. It is called
                before the result is sent: what a client has read in a result must outlive this
                process.
            finish: ends the goal by the call that it is given.
        """
        self.robots = tuple(context.name for context in contexts)
        self._ability = ability
        self._running = running
        self._keep = keep
        self._finish = finish
        self._contexts = contexts
        self._steps = occupy(contexts, ability.perform(*contexts, goal))

    def __str__(self) -> str:
        """Name the ability and its goal."""
        return f"{self._ability.name} (goal {self._running.goal.id!r})"

    def stop(self) -> None:
        """Leave the steps where they are; the arms stay where they were sent."""
        self._steps.close()

    def step(self) -> bool:
        """Do the next step; returns whether the goal has come to its end."""
        try:
            self._running.check()
            next(self._steps)
        except StopIteration as done:
            self._succeed(done.value)
        except AbilityError as error:
            self.fail(error)
        except Exception as error:  # noqa: BLE001 - a goal must end whatever happens
            rospy.logerr("%s: %s", self, traceback.format_exc())
            self._end(Code.INTERNAL, f"{type(error).__name__}: {error}; the log has more", {})
        else:
            every = (context.progress for context in self._contexts)
            progress = max(every, key=lambda progress: progress.share)
            self._running.report(progress.message, 100.0 * progress.share)
            return False
        return True

    def fail(self, error: AbilityError) -> None:
        """End the goal with an error."""
        self._end(Code(error.code), str(error), error.found)

    def _succeed(self, found: AbilityResult) -> None:
        try:
            self._keep()
        except MemoryFileError as error:
            self._end(Code.INTERNAL, f"{found.message}, but it is not kept: {error}", {})
            return
        fields = result_fields(found, self._running.goal)
        self._running.report(found.message, 100.0)
        rospy.loginfo("%s: %s (%.1f s)", self, found.message, self._running.elapsed_s)
        self._finish(lambda: self._running.succeed(found.message, fields))

    def _end(self, code: Code, text: str, found: Mapping[str, Any]) -> None:
        self.stop()
        try:
            self._keep()
        except MemoryFileError as error:
            rospy.logerr("%s: %s", self, error)
        message = f"{self._ability.name}: {code.name}"
        rospy.loginfo("%s: %s: %s (%.1f s)", self, code.name, text, self._running.elapsed_s)
        self._finish(lambda: self._running.fail(code, text, found, message))
