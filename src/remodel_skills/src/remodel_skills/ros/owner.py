"""The one thread that owns the cell, and the goals that it does.

It runs the abilities, and answers requests between their ticks. rospy's threads only leave requests
here: belief and plant are used by this thread alone. The abilities of two robots take turns: each
does one step, then a tick passes for both. In a simulated cell time runs as fast as the machine
allows while an ability runs; between goals the scene is frozen and time goes on at the wall's pace,
so that results depend on the seed and the goals alone, not on how long a client thinks.
"""

from __future__ import annotations

import math
import queue
import threading
import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, Protocol, TypeVar

import rospy
from genpy import Message
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from remodel_msgs.msg import CableObservation

from remodel_skills.abilities.ability import AbilityResult, CellAbility, Goal
from remodel_skills.abilities.picking import CableDetected
from remodel_skills.cell import Cell
from remodel_skills.robot_context import RobotContext, occupy
from remodel_states.core import ability_error
from remodel_states.core.codes import Code
from remodel_states.serving import RunningGoal
from remodel_work.errors import AbilityError, CellError, MemoryFileError
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
        truncated=False,  # a wire that leaves the picture fails
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
        except ability_error.AbilityError as error:
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

    def fail(self, error: ability_error.AbilityError) -> None:
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


T = TypeVar("T")

# The idle loop checks for shutdown and publishes the time this often [s of wall time].
IDLE_S = 0.01


class Clock(Protocol):
    """The time of a cell."""

    @property
    def now_s(self) -> float:
        """The time [s]."""

    @property
    def now(self) -> rospy.Time:
        """The time as messages have it."""

    def idle(self) -> None:
        """Do what time takes to go on while nothing runs; returns at once."""


class Owner:
    """Runs the cell. `spin` must be called by the thread that built the cell."""

    def __init__(self, cell: Cell, clock: Clock) -> None:
        """Take a cell over."""
        self.cell = cell
        self.clock = clock
        self.jobs: list[Job] = []
        # Not a SimpleQueue: its get() waits forever once a signal has come during a timeout.
        self._requests: queue.Queue[Callable[[], None]] = queue.Queue()
        self._frozen_until_s = -math.inf

    def job_of(self, robot: str) -> Job | None:
        """Return what a robot is doing."""
        return next((job for job in self.jobs if robot in job.robots), None)

    def post(self, action: Callable[[], None]) -> None:
        """Queue an action for the time between two ticks; from any thread, returns at once."""
        self._requests.put(action)

    def ask(self, question: Callable[[], T], timeout_s: float) -> T:
        """Evaluate a function between two ticks; from any thread but the owner's.

        Raises:
            CellError: when there is no answer in time, or what the question itself raises.
        """
        answer: _Answer[T] = _Answer(question)
        self.post(answer.find)
        return answer.wait(timeout_s)

    def freeze(self, seconds: float) -> None:
        """Do nothing for so long: no step, no answer, no cancel; only the clock goes on."""
        self._frozen_until_s = self.clock.now_s + seconds

    def spin(self, is_over: Callable[[], bool]) -> None:
        """Run until `is_over` returns that the node ends."""
        pause = threading.Event()
        while not is_over():
            if self.clock.now_s < self._frozen_until_s:
                pause.wait(IDLE_S)
                self.clock.idle()
                continue
            if not self.turn(0.0 if self.jobs else IDLE_S):
                self.clock.idle()
        self.stop()

    def turn(self, wait_s: float = 0.0) -> bool:
        """Answer what was asked, and let one tick pass if a goal is being done.

        Args:
            wait_s: [s] wall time for which to wait for a request.

        Returns:
            whether a goal is, or was, being done.
        """
        self._serve(wait_s)
        if not self.jobs:
            return False
        self._tick()
        return True

    def stop(self) -> None:
        """Leave all goals where they are."""
        for job in self.jobs:
            job.stop()
        self.jobs.clear()

    def _serve(self, wait_s: float) -> None:
        try:
            action = self._requests.get(block=wait_s > 0.0, timeout=wait_s or None)
            while True:
                action()
                action = self._requests.get_nowait()
        except queue.Empty:
            return

    def _tick(self) -> None:
        for job in tuple(self.jobs):
            if job.step():
                self.jobs.remove(job)
        try:
            if self.jobs:
                self.cell.plant.tick()
            else:
                self.cell.come_to_rest()
        except MemoryFileError as error:
            # The next goal stores it again; its result says when that fails, too.
            rospy.logerr("%s", error)
        except AbilityError as error:
            # The plant is at fault, whatever the skills were doing.
            rospy.logerr("%s", error)
            for job in self.jobs:
                job.fail(error)
            self.jobs.clear()


class _Answer(Generic[T]):
    """A question on its way to the owner and back."""

    def __init__(self, question: Callable[[], T]) -> None:
        self._question = question
        self._done = threading.Event()
        self._value: T | None = None
        self._error: Exception | None = None

    def find(self) -> None:
        try:
            self._value = self._question()
        except Exception as error:  # noqa: BLE001 - raised again in the thread that asked
            self._error = error
        self._done.set()

    def wait(self, timeout_s: float) -> T:
        if not self._done.wait(timeout_s):
            raise CellError(f"the cell did not answer within {timeout_s:.0f} s; check its log")
        if self._error is not None:
            raise self._error
        return self._value  # type: ignore[return-value]
