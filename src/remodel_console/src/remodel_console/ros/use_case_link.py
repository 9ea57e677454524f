"""The commands that the console gives to the use case supervisor."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable

import actionlib
from actionlib_msgs.msg import GoalStatus
from remodel_msgs import srv
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal

from flexbe_core.ros.connections import is_heard
from remodel_console.core.use_case.use_case import UseCase
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.call_service import LIMIT_S, call_service
from remodel_console.ros.run_subscriber import RunSubscriber
from remodel_run.progress import Answer

_ACCEPTED_S = 8.0  # in which a supervisor accepts or rejects an order; wall time
_STANDSTILL_S = 900.0  # in which all motion ends: what holds a run is answered when nothing moves
_REFUSALS = (GoalStatus.REJECTED, GoalStatus.ABORTED)


class UseCaseLink:
    """Subscribes to the supervisor of this namespace, and commands it."""

    def __init__(self, take: Callable[[UseCase], None]) -> None:
        """Connect; `take` is called on other threads with each state."""
        self._client = actionlib.ActionClient(topics.RUN_USE_CASE, RunUseCaseAction)
        self._run = RunSubscriber(take)

    @property
    def is_there(self) -> bool:
        """Return whether a supervisor publishes its state."""
        return self._run.is_there

    def run(self, order: str, tasks: int, by: str, *, again: bool, use_case: str = "") -> str:
        """Start an order, and return what the supervisor says.

        Args:
            order: its name.
            tasks: how many of its tasks, from the first; 0 for all.
            by: who starts it.
            again: do those too that are done, on an empty panel.
            use_case: by which it is done; empty: the supervisor's default.

        Raises:
            CommandError: if there is no supervisor, or it refuses.
        """
        if not is_heard(self._client.pub_goal):
            raise CommandError("no use case supervisor is running to take the order")
        decided = threading.Event()

        def on_change(handle: actionlib.ClientGoalHandle) -> None:
            if handle.get_comm_state() not in (
                actionlib.CommState.WAITING_FOR_GOAL_ACK,
                actionlib.CommState.PENDING,
            ):
                decided.set()

        goal_id = f"{by}-{uuid.uuid4().hex[:8]}"
        goal = RunUseCaseGoal(id=goal_id, order=order, use_case=use_case, tasks=tasks, again=again)
        handle = self._client.send_goal(goal, on_change)
        if not decided.wait(_ACCEPTED_S):
            handle.cancel()
            raise CommandError(f"the supervisor has not answered within {_ACCEPTED_S:.0f} s")
        if handle.get_goal_status() in _REFUSALS:
            raise CommandError(f"the supervisor refuses: {handle.get_goal_status_text()}")
        return f"order '{order}' started"

    def pause(self, by: str) -> str:
        """Have the run pause, and return when nothing moves any more; see `_command`."""
        return self._hold("pause", by)

    def resume(self, by: str) -> str:
        """Have the run go on; see `_command`."""
        return self._command("resume", srv.CommandRun, srv.CommandRunRequest(by=by))

    def release(self, by: str) -> str:
        """Release the protective stops of persons; see `_command`."""
        return self._command("release", srv.CommandRun, srv.CommandRunRequest(by=by))

    def stop(self, by: str) -> str:
        """Have the run stopped safely, and return when nothing moves; see `_command`."""
        return self._hold("stop", by)

    def protective_stop(self, by: str) -> str:
        """Stop all motion at once, and return when nothing moves; see `_command`."""
        return self._hold("protective_stop", by)

    def skip(self, task: str, by: str) -> str:
        """Have a task left undone, and return when nothing of it moves; see `_command`."""
        request = srv.CommandTaskRequest(task, by)
        return self._command("skip", srv.CommandTask, request, _STANDSTILL_S)

    def retry(self, task: str, by: str) -> str:
        """Have a task done again; see `_command`."""
        return self._command("retry", srv.CommandTask, srv.CommandTaskRequest(task, by))

    def answer(self, question: int, choice: Answer, by: str) -> str:
        """Answer a question by its number; see `_command`."""
        request = srv.AnswerQuestionRequest(question, choice.value, by)
        return self._command("answer", srv.AnswerQuestion, request)

    def _hold(self, name: str, by: str) -> str:
        return self._command(name, srv.CommandRun, srv.CommandRunRequest(by=by), _STANDSTILL_S)

    @staticmethod
    def _command(name: str, kind: type, request: object, limit_s: float = LIMIT_S) -> str:
        """Give a command and return the supervisor's answer.

        Args:
            name: of the service.
            kind: of the service.
            request: to it.
            limit_s: wall time in which it answers [s].

        Raises:
            CommandError: if it cannot be given, or is refused.
        """
        answer = call_service(f"{topics.RUN_COMMANDS}/{name}", kind, request, limit_s)
        if not answer.success:
            raise CommandError(f"the supervisor refuses: {answer.message}")
        return str(answer.message)
