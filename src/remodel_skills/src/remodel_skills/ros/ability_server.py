"""An ability served over ROS: its goal, its job, and its result."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import rospy
from genpy import Message
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from remodel_msgs.msg import CableObservation

from remodel_skills.abilities.ability import CellAbility
from remodel_skills.abilities.detect_cable import CableDetected
from remodel_skills.goal_checks import require, require_number
from remodel_skills.goals import Goal
from remodel_skills.robot_context import AbilityResult, RobotContext
from remodel_skills.ros.owner import Owner
from remodel_skills.runner import occupy
from remodel_states.ability_server import AbilityServer
from remodel_states.core.ability_error import AbilityError as ReportedError
from remodel_states.core.ability_tables import Ability
from remodel_states.core.codes import Code
from remodel_states.core.contract import ROBOT_FIELDS, owner_of
from remodel_states.serving import RunningGoal
from remodel_work.errors import AbilityError, MemoryFileError
from remodel_work.geometry import WORLD, Pose
from remodel_work.robot.arm import ToolPose


def pose_stamped(pose: Pose) -> PoseStamped:
    """Return a pose as a message in the world frame."""
    message = PoseStamped()
    message.header.frame_id = WORLD
    message.header.stamp = rospy.Time.now()
    message.pose.position = Point(*(float(v) for v in pose.position))
    message.pose.orientation = Quaternion(*(float(v) for v in pose.quaternion))
    return message


def observation(detected: CableDetected, cable_id: str) -> CableObservation:
    """Return what DetectCable saw as a message."""
    tips = [pose_stamped(Pose.level(*(float(v) for v in t.tip), t.out_yaw)) for t in detected.tips]
    return CableObservation(
        cable_id=cable_id,
        centreline=[Point(*(float(v) for v in point)) for point in detected.centreline],
        tips=tips,
        length=detected.length,
        confidence=detected.confidence,
        truncated=detected.truncated,
    )


def result_fields(found: AbilityResult, goal: Message) -> dict[str, object]:
    """Return what an ability found out as fields of its result."""
    if isinstance(found, CableDetected):
        return {"observation": observation(found, goal.cable_id)}
    values = {name: value for name, value in vars(found).items() if name != "message"}
    return {name: _field(value) for name, value in values.items() if value is not None}


def _field(value: object) -> object:
    if isinstance(value, Pose):
        return pose_stamped(value)
    if isinstance(value, ToolPose):
        return pose_stamped(Pose.level(value.x, value.y, value.z, value.yaw))
    return value


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
        except ReportedError as error:
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

    def fail(self, error: ReportedError) -> None:
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


MAX_TIMEOUT_S = 3600.0


class CellAbilityServer(AbilityServer):
    """Takes goals for one ability; a robot does one goal at a time, over all abilities."""

    def __init__(self, ability: Ability, steps: CellAbility, owner: Owner) -> None:
        """Start to serve."""
        self._steps = steps
        self._owner = owner
        super().__init__(ability)

    def schedule(self, take: Callable[[], None]) -> None:
        """Queue a new goal, to be accepted between two ticks."""
        self._owner.post(take)

    def prepare(self, goal: Message) -> tuple[list[RobotContext], Goal]:
        """Return the robots for a goal, and the goal."""
        self._owner.cell.admit(owner_of(goal.id))
        contexts = self._contexts(goal)
        return contexts, self._checked(goal, contexts)

    def start(self, running: RunningGoal, prepared: tuple[list[RobotContext], Goal]) -> None:
        """Queue a goal for the owner of the plant."""
        finish, keep = partial(self.finish, running), self._owner.cell.keep
        self._owner.jobs.append(Job(self._steps, running, *prepared, keep=keep, finish=finish))

    def elapsed(self) -> Callable[[], float]:
        """Return the plant's clock, from now on."""
        clock = self._owner.clock
        began_s = clock.now_s
        return lambda: clock.now_s - began_s

    def _contexts(self, message: Message) -> list[RobotContext]:
        """Return the robots that a goal names, or the one that is free for it when it names none.

        Raises UNKNOWN_NAME, or BUSY when one of them does another goal.
        """
        cell = self._owner.cell
        fields = [field for field in ROBOT_FIELDS if field in message.__slots__]
        if fields:
            contexts = [cell.context_of(getattr(message, field)) for field in fields]
        else:
            contexts = [self._free_context()]
        for context in contexts:
            job = self._owner.job_of(context.name)
            if job is not None:
                text = f"{context.name} is doing {job}; wait for it or cancel it"
                raise AbilityError(Code.BUSY, text)
            if context.busy:
                raise AbilityError(
                    Code.BUSY, f"{context.name} is making way for another robot; try again"
                )
        return contexts

    def _free_context(self) -> RobotContext:
        """Return a robot for an observation: an idle one, preferably with an empty hand."""

        def rank(context: RobotContext) -> tuple[bool, bool]:
            return context.busy, context.belief.grip is not None

        return min(self._owner.cell.contexts.values(), key=rank)

    def _checked(self, message: Message, contexts: Sequence[RobotContext]) -> Goal:
        """Return the goal of a message; raises AbilityError when it cannot be taken."""
        require(bool(message.id.strip()), "id is empty; it must name the goal")
        require_number("timeout", message.timeout, 0.1, MAX_TIMEOUT_S, unit="s")
        goal = self._steps.parse(message, self._owner.cell.plant.panel.world_from_panel)
        for context in contexts:
            goal.check(context.panel, context.belief, context.parameters)
        return goal
