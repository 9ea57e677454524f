"""The use case supervisor: its run followed, its commands, its recorded runs."""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import TypeVar

import actionlib
import genpy
import rospy
from actionlib_msgs.msg import GoalStatus
from remodel_msgs import msg, srv
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal

from flexbe_core.ros.master import is_heard
from remodel_console.core.record import Record, Summary
from remodel_console.core.use_case import (
    Changes,
    Failure,
    Level,
    Question,
    Snapshot,
    Task,
    TaskCopy,
    UseCase,
)
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.calls import LIMIT_S, call_service
from remodel_run.progress import Answer, Count, HandWire, Phase, Sums, TaskPhase
from remodel_run.record import Entry, Kind, Statistics

T = TypeVar("T")


def _like(kind: type[T], message: genpy.Message, /, **own: object) -> T:
    """Return a dataclass of a message: its fields have the message's values of their names.

    `own` has the values of the fields that the message spells otherwise, or not at all.
    """
    same = {each.name for each in fields(kind)} - own.keys()
    return kind(**{name: getattr(message, name) for name in same}, **own)


def use_case_of(message: msg.UseCaseState, copy: TaskCopy) -> UseCase:
    """Return the run of a state, with the tasks and failures of a copy if it is of this run."""
    has_tasks = copy.series == message.series
    return _like(
        UseCase,
        message,
        phase=Phase(message.phase),
        stamp_s=message.stamp.to_sec(),
        started_s=message.started.to_sec(),
        controllers=tuple(message.controllers),
        sums=sums_of(message.sums),
        by_hand=copy.by_hand if has_tasks else (),
        tasks=copy.in_order if has_tasks else (),
        levels=tuple(_like(Level, m, since_s=m.since.to_sec()) for m in message.levels),
        failures=copy.failures if has_tasks else (),
        question=_question(message.question) if message.question.number else None,
    )


def changes_of(message: msg.UseCaseChanges) -> Changes:
    """Return what has changed in the tasks."""
    return _like(Changes, message, **_tasks_of(message))


def snapshot_of(answer: srv.GetTasksResponse) -> Snapshot:
    """Return all tasks."""
    by_hand = (
        _like(HandWire, each, section_mm2=each.section, length_m=each.length)
        for each in answer.by_hand
    )
    return _like(Snapshot, answer, by_hand=tuple(by_hand), **_tasks_of(answer))


def sums_of(message: msg.RunSums) -> Sums:
    """Return the sums of a run."""
    return _like(Sums, message)


def _question(message: msg.OperatorQuestion) -> Question:
    known = {choice.value: choice for choice in Answer}
    return _like(
        Question,
        message,
        choices=tuple(known[one] for one in message.choices if one in known),
        asked_s=message.asked.to_sec(),
        timeout_s=message.timeout,
    )


def _tasks_of(message: msg.UseCaseChanges | srv.GetTasksResponse) -> dict[str, object]:
    tasks = (
        _like(Task, each, phase=TaskPhase(each.state), counts_as=Count(each.counts_as))
        for each in message.tasks
    )
    failures = (_like(Failure, each, time_s=each.stamp.to_sec()) for each in message.failures)
    return {"tasks": tuple(tasks), "failures": tuple(failures)}


# [s] wall time in which changes that a state announces arrive on their own topic; and between two
# fetches of all tasks.
_LATE_S = 1.0
_FETCH_EVERY_S = 0.5


class RunSubscriber:
    """Keeps a copy of the run, and passes it on whenever it changes.

    All tasks are fetched when a run is seen first, when changes were missed, and when the order of
    the tasks has changed. A run is passed on without tasks only if they could not be fetched.
    """

    def __init__(self, take: Callable[[UseCase], None]) -> None:
        """Subscribe; `take` is called with each state of the run, one call at a time."""
        self._take = take
        self._lock = threading.Lock()
        self._state: msg.UseCaseState | None = None
        self._copy = TaskCopy()
        self._behind_since: float | None = None
        self._failed_series = 0
        self._wanted = threading.Event()
        # Before the state, so that no change is missed after the first one.
        rospy.Subscriber(topics.TASK_CHANGES, msg.UseCaseChanges, self._on_changes)
        self._states = rospy.Subscriber(topics.USE_CASE, msg.UseCaseState, self._on_state)
        threading.Thread(target=self._fetch, name="fetch tasks", daemon=True).start()

    @property
    def is_there(self) -> bool:
        """Return whether a supervisor publishes its state."""
        return bool(self._states.get_num_connections() > 0)

    def _on_state(self, message: msg.UseCaseState) -> None:
        with self._lock:
            self._state = message
            self._pass_on()

    def _on_changes(self, message: msg.UseCaseChanges) -> None:
        with self._lock:
            self._copy = self._copy.with_changes(changes_of(message))
            self._pass_on()

    def _pass_on(self) -> None:
        """Pass the run on, and have its tasks fetched if they are not known."""
        state = self._state
        if state is None:
            return
        if self._is_fetch_needed(state):
            self._wanted.set()
        if state.series in (0, self._copy.series, self._failed_series):
            self._take(use_case_of(state, self._copy))

    def _is_fetch_needed(self, state: msg.UseCaseState) -> bool:
        if self._copy.needs_snapshot(state.series):
            return True
        if state.series != self._copy.series or state.changes <= self._copy.number:
            self._behind_since = None
            return False
        self._behind_since = self._behind_since or time.monotonic()
        return time.monotonic() - self._behind_since > _LATE_S

    def _fetch(self) -> None:
        """Fetch all tasks whenever that is needed; again later, if it failed."""
        while not rospy.is_shutdown():
            self._wanted.wait()
            self._wanted.clear()
            answer = self._answer()
            with self._lock:
                self._behind_since = None
                if answer is not None:
                    self._copy = self._copy.with_snapshot(snapshot_of(answer))
                elif self._state is not None:
                    self._failed_series = self._state.series
                self._pass_on()
            threading.Event().wait(_FETCH_EVERY_S)

    def _answer(self) -> srv.GetTasksResponse | None:
        """Return all tasks; None without an answer."""
        try:
            answer = call_service(topics.TASKS, srv.GetTasks, srv.GetTasksRequest())
        except CommandError as error:
            rospy.logwarn("the tasks of the run are not known: %s", error)
            return None
        return answer if answer.success else None


_KINDS = {kind.value: kind for kind in Kind}


class RecordLink:
    """Asks for runs and their records; each call raises CommandError if no node serves them."""

    def runs(self) -> tuple[Summary, ...]:
        """Return the recorded runs, the latest first."""
        return tuple(map(summary_of, self._list().runs))

    def orders(self) -> tuple[str, ...]:
        """Return the names of all orders."""
        return tuple(self._list().orders)

    def statistics(self, order: str) -> Statistics:
        """Return the statistics of an order's runs; of an empty name: of all runs."""
        name = f"{topics.RUN_COMMANDS}/statistics"
        answer = call_service(name, srv.GetStatistics, srv.GetStatisticsRequest(order))
        if not answer.success:
            raise CommandError(f"the statistics cannot be read: {answer.message}")
        terminals = zip(answer.terminals, answer.insertions, answer.failures, strict=True)
        return Statistics(
            tuple(zip(answer.runs, map(sums_of, answer.sums), strict=True)),
            tuple(zip(answer.runs, answer.yields, strict=True)),
            tuple(zip(answer.runs, answer.utilisations, strict=True)),
            tuple(terminals),
            tuple(zip(answer.wires, answer.wire_s, strict=True)),
        )

    def record(self, run: int) -> Record:
        """Return the record of a run, without its pictures."""
        return Record(tuple(self._entries(run)))

    def picture(self, run: int, position: int) -> bytes:
        """Return the picture of an entry, as jpeg or png; none is an error, too."""
        answer = _get(srv.GetRunRequest(run, position, 1, True))
        if not answer.entries or not answer.entries[0].has_picture:
            raise CommandError(f"entry {position} of run {run} has no picture")
        return bytes(answer.entries[0].picture.data)

    def _entries(self, run: int) -> Iterator[Entry]:
        """Yield all entries; the server gives some at once."""
        first = 1
        while True:
            answer = _get(srv.GetRunRequest(run, first, 0, False))
            yield from map(_entry, answer.entries)
            if not answer.entries or answer.entries[-1].position >= answer.total:
                return
            first = answer.entries[-1].position + 1

    @staticmethod
    def _list() -> srv.ListRunsResponse:
        answer = call_service(f"{topics.RUN_COMMANDS}/runs", srv.ListRuns, srv.ListRunsRequest())
        if not answer.success:
            raise CommandError(f"the runs cannot be listed: {answer.message}")
        return answer


def _get(request: srv.GetRunRequest) -> srv.GetRunResponse:
    answer = call_service(f"{topics.RUN_COMMANDS}/record", srv.GetRun, request)
    if not answer.success:
        raise CommandError(f"run {request.run} cannot be read: {answer.message}")
    return answer


def summary_of(message: msg.RunSummary) -> Summary:
    """Return a run as a list of runs shows it."""
    return _like(
        Summary,
        message,
        started_s=message.started.to_sec(),
        has_ended=message.ended,
        is_success=message.success,
        sums=sums_of(message.sums),
    )


def _entry(message: msg.RunEntry) -> Entry:
    if message.kind not in _KINDS:
        raise CommandError(
            f"entry {message.position} is of the kind '{message.kind}', which is not known here; "
            f"known are {', '.join(_KINDS)}"
        )
    return _like(
        Entry,
        message,
        time_s=message.stamp.to_sec(),
        kind=_KINDS[message.kind],
        values=tuple(zip(message.names, message.values, strict=False)),
        state="",
    )


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
        """Start an order, and return when it is accepted; see `console.Supervisor`."""
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
        """Give a command and return the supervisor's answer; see `call_service`.

        Raises:
            CommandError: if it cannot be given, or is refused.
        """
        answer = call_service(f"{topics.RUN_COMMANDS}/{name}", kind, request, limit_s)
        if not answer.success:
            raise CommandError(f"the supervisor refuses: {answer.message}")
        return str(answer.message)
