"""The use case supervisor as the console sees it: its state, and the ways to command it."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from remodel_msgs import msg, srv
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal

from remodel_console.core.use_case import (
    Choice,
    Failure,
    Level,
    Phase,
    Question,
    Task,
    TaskPhase,
    UseCase,
)
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service

_ACCEPTED_S = 8.0  # in which a supervisor says whether it takes an order; wall time
_REFUSALS = (GoalStatus.REJECTED, GoalStatus.ABORTED)


class UseCaseLink:
    """Subscribes to the supervisor of this namespace, and commands it."""

    def __init__(self, tell: Callable[[UseCase], None]) -> None:
        """Connect; `tell` is called on a thread of its own with each state."""
        self._client = actionlib.ActionClient(topics.RUN_USE_CASE, RunUseCaseAction)
        self._state = rospy.Subscriber(
            topics.USE_CASE, msg.UseCaseState, lambda m: tell(_use_case(m))
        )

    @property
    def is_there(self) -> bool:
        """Tell whether a supervisor publishes its state."""
        return bool(self._state.get_num_connections() > 0)

    def run(self, order: str, tasks: int, by: str, *, again: bool) -> str:
        """Start an order, and return what the supervisor says.

        Args:
            order: its name.
            tasks: how many of its tasks, from the first; 0 for all.
            by: who starts it.
            again: do those too that are done, on an empty panel.

        Raises:
            CommandError: if there is no supervisor, or it refuses.
        """
        if self._client.pub_goal.get_num_connections() == 0:
            raise CommandError("no use case supervisor is there to take the order")
        decided = threading.Event()

        def on_change(handle: actionlib.ClientGoalHandle) -> None:
            if handle.get_comm_state() not in (
                actionlib.CommState.WAITING_FOR_GOAL_ACK,
                actionlib.CommState.PENDING,
            ):
                decided.set()

        goal_id = f"{by}-{uuid.uuid4().hex[:8]}"
        goal = RunUseCaseGoal(id=goal_id, order=order, tasks=tasks, again=again)
        handle = self._client.send_goal(goal, on_change)
        if not decided.wait(_ACCEPTED_S):
            handle.cancel()
            raise CommandError(f"the supervisor has not answered within {_ACCEPTED_S:.0f} s")
        if handle.get_goal_status() in _REFUSALS:
            raise CommandError(f"the supervisor refuses: {handle.get_goal_status_text()}")
        return f"order '{order}' runs"

    def pause(self, by: str) -> str:
        """Have the run pause; see `_command`."""
        return self._command("pause", srv.CommandRun, srv.CommandRunRequest(by=by))

    def resume(self, by: str) -> str:
        """Have the run go on; see `_command`."""
        return self._command("resume", srv.CommandRun, srv.CommandRunRequest(by=by))

    def stop(self, by: str) -> str:
        """Have the run stopped safely; see `_command`."""
        return self._command("stop", srv.CommandRun, srv.CommandRunRequest(by=by))

    def skip(self, task: str, by: str) -> str:
        """Have a task left undone; see `_command`."""
        return self._command("skip", srv.CommandTask, srv.CommandTaskRequest(task, by))

    def retry(self, task: str, by: str) -> str:
        """Have a task done again; see `_command`."""
        return self._command("retry", srv.CommandTask, srv.CommandTaskRequest(task, by))

    def answer(self, question: int, choice: Choice, by: str) -> str:
        """Answer a question by its number; see `_command`."""
        request = srv.AnswerQuestionRequest(question, choice.value, by)
        return self._command("answer", srv.AnswerQuestion, request)

    @staticmethod
    def _command(name: str, kind: type, request: object) -> str:
        """Give a command and return what the supervisor says.

        Raises:
            CommandError: if it cannot be given, or is refused.
        """
        answer = call_service(f"{topics.RUN_COMMANDS}/{name}", kind, request)
        if not answer.success:
            raise CommandError(f"the supervisor refuses: {answer.message}")
        return str(answer.message)


def _use_case(message: msg.UseCaseState) -> UseCase:
    question = message.question
    known = {choice.value: choice for choice in Choice}
    return UseCase(
        phase=Phase(message.phase),
        told_s=message.stamp.to_sec(),
        message=message.message,
        cell=message.cell,
        run=message.run,
        order=message.order,
        use_case=message.use_case,
        started_s=message.started.to_sec(),
        interruptions=message.interruptions,
        tasks=tuple(map(_task, message.tasks)),
        task=message.task,
        levels=tuple(Level(m.level, m.name, m.doing, m.since.to_sec()) for m in message.levels),
        failures=tuple(map(_failure, message.failures)),
        question=Question(
            question.number,
            question.task,
            question.text,
            tuple(known[one] for one in question.choices if one in known),
        )
        if question.number
        else None,
    )


def _task(message: msg.TaskState) -> Task:
    return Task(
        name=message.name,
        description=message.description,
        phase=TaskPhase(message.state),
        attempts=message.attempts,
        first_pass=message.first_pass,
        taken_s=message.taken_s,
        expected_s=message.expected_s,
    )


def _failure(message: msg.FailureState) -> Failure:
    return Failure(
        time_s=message.stamp.to_sec(),
        task=message.task,
        fault=message.fault,
        error_code=message.error_code,
        ability=message.ability,
        text=message.text,
        decision=message.decision,
        because=message.because,
    )
