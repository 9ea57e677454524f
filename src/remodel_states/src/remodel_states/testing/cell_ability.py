"""The action server of one ability of a fake cell."""

from __future__ import annotations

import os
import signal
import threading
import traceback
from dataclasses import dataclass
from random import Random

import actionlib
import rospy
from genpy import Message
from remodel_msgs import msg as remodel_msgs
from remodel_msgs.msg import ErrorCode

from flexbe_core.ros.steady_action_server import SteadyActionServer
from remodel_states.testing.faults import Behaves, Fault, at_goal
from remodel_states.testing.job import Job, Stopped
from remodel_states.testing.nonsense import nonsense
from remodel_states.testing.operations import OPERATIONS, Effect, perform
from remodel_states.testing.ownership import admitted, owner_of
from remodel_states.testing.panel import fill_result
from remodel_states.testing.robot_lock import RobotLock
from remodel_states.testing.world import WorldError
from remodel_states.testing.world_file import WorldFile


@dataclass(frozen=True)
class Site:
    """What the processes of a fake cell share.

    Attributes:
        file: the world.
        lock_path: file that the robot's goals lock.
        cell: name of the cell.
        duration_s: [s] wall time that an operation takes, on average.
        seed: of all that is random.
    """

    file: WorldFile
    lock_path: str
    cell: str
    duration_s: float
    seed: int

    def random(self, ability: str, number: int) -> Random:
        """Return the random numbers of an ability's n-th goal."""
        return Random(f"{self.seed} {self.cell} {ability} {number}")

    def admit(self, owner: int) -> None:
        """Check the token of a supervisor, and remember it if it is the newest; 0 is not checked.

        Raises:
            WorldError: if it is stale.
        """
        if owner:
            with self.file.change() as draft:
                draft.owners = admitted(draft.owners, self.cell, owner)


class CellAbility:
    """Serves one ability; the robot does one goal at a time, over all abilities of the cell."""

    def __init__(self, ability: str, site: Site) -> None:
        """Start to serve, on the ability's usual topic."""
        self._ability = ability
        self._site = site
        self._operation = OPERATIONS[ability]
        self._result = getattr(remodel_msgs, f"{ability}Result")
        self._feedback = getattr(remodel_msgs, f"{ability}Feedback")
        self._lock = RobotLock(site.lock_path)
        self._jobs: dict[str, Job] = {}
        self._server = SteadyActionServer(
            f"remodel_abilities/{ability.lower()}",
            getattr(remodel_msgs, f"{ability}Action"),
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = handle.get_goal()
        senseless = nonsense(goal)
        if senseless:
            self._refuse(handle, ErrorCode.INVALID_GOAL, senseless)
            return
        if not self._lock.take():
            self._refuse(handle, ErrorCode.BUSY, "the robot is doing another goal; wait for it")
            return
        try:
            fault, random = self._begin(goal)
        except WorldError as error:
            self._lock.free()
            self._refuse(handle, error.code, str(error))
            return
        job = Job(handle, self._feedback, fault, random, self._site.duration_s)
        self._jobs[handle.get_goal_id().id] = job
        handle.set_accepted()
        threading.Thread(target=self._perform, args=(job,), daemon=True).start()

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        job = self._jobs.get(handle.get_goal_id().id)
        if job is not None:
            job.cancel()

    def _begin(self, goal: Message) -> tuple[Fault | None, Random]:
        """Count a goal that can be taken; return the fault that strikes it, if any.

        Raises:
            WorldError: if it cannot be taken.
        """
        self._site.admit(owner_of(goal.id))
        with self._site.file.change() as draft:
            self._operation.check(draft.world, self._site.cell, goal)
            included = self._operation.includes(draft.world, self._site.cell, goal)
            draft.faults, fault = at_goal(draft.faults, self._ability, goal, included)
            number = draft.goals[self._ability] = draft.goals.get(self._ability, 0) + 1
        return fault, self._site.random(self._ability, number)

    def _perform(self, job: Job) -> None:
        result = self._result(id=job.goal.id)
        try:
            effect = self._work(job)
            result.success, result.message = True, effect.said
            fill_result(result, effect.found)
        except (Stopped, WorldError) as error:
            result.error_code, result.error_message = error.code, str(error)
        except Exception as error:  # noqa: BLE001 - a goal must end whatever happens
            rospy.logerr("%s: %s", self._ability, traceback.format_exc())
            result.error_code, result.error_message = ErrorCode.INTERNAL, str(error)
        result.elapsed_time = job.elapsed_s
        del self._jobs[job.handle.get_goal_id().id]
        # Free before the answer is out: the next goal may come to another process.
        self._lock.free()
        self._answer(job, result)

    def _work(self, job: Job) -> Effect:
        """Do the goal, as far as its fault lets it."""
        behaves = job.fault.behaves if job.fault else None
        happens = behaves is None or job.random.random() < 0.5
        job.wait_until(job.course.effect_s)
        effect = self._take_effect(job) if happens else Effect(self._site.file.read().world, "")
        if behaves is Behaves.DIES:
            os.kill(os.getpid(), signal.SIGKILL)
        if behaves is Behaves.HANGS:
            job.hang()
        job.wait_until(job.course.end_s)
        if job.fault and behaves is None:
            text = f"{job.fault.name}, strike {job.fault.struck}"
            raise Stopped(job.fault.code, text)
        return effect

    def _take_effect(self, job: Job) -> Effect:
        cell = self._site.cell
        with self._site.file.change() as draft:
            admitted(draft.owners, cell, owner_of(job.goal.id))  # it may have lost the cell since
            code = job.fault.code if job.fault and job.fault.behaves is None else 0
            effect = perform(self._ability, draft.world, cell, job.goal, code)
            draft.world = effect.world
            draft.entries += effect.entries
        return effect

    def _answer(self, job: Job, result: Message) -> None:
        if result.success and job.fault:
            result.error_code, result.error_message = ErrorCode.INTERNAL, job.fault.name
        if result.error_code == ErrorCode.PREEMPTED:
            job.handle.set_canceled(result, result.error_message)
        elif result.error_code != ErrorCode.NONE:
            job.handle.set_aborted(result, result.error_message)
        else:
            job.tell(100.0)
            job.handle.set_succeeded(result, result.message)

    def _refuse(self, handle: actionlib.ServerGoalHandle, code: int, text: str) -> None:
        goal = handle.get_goal()
        rospy.logwarn("%s (goal %r) refused: %d: %s", self._ability, goal.id, code, text)
        handle.set_rejected(self._result(id=goal.id, error_code=code, error_message=text), text)
