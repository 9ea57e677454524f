"""Serve runs of orders: the action remodel/run_use_case, an operator's services, a latched state.

At its start it goes on with the run of its cell that was cut short, if there is one.
"""

from __future__ import annotations

import contextlib
import threading
import time
import traceback
from dataclasses import dataclass, replace
from pathlib import Path

import actionlib
import rospy
from remodel_msgs.msg import (
    ErrorCode,
    RunUseCaseAction,
    RunUseCaseFeedback,
    RunUseCaseGoal,
    RunUseCaseResult,
    UseCaseState,
)
from remodel_msgs.srv import (
    AnswerQuestion,
    AnswerQuestionResponse,
    CommandRun,
    CommandRunResponse,
    CommandTask,
    CommandTaskResponse,
)

from remodel_planner.core.supervision.events import (
    Answer,
    Answered,
    Command,
    Commanded,
    Ending,
    RunBegun,
)
from remodel_planner.core.supervision.state import RunState, Stage, state_after
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.run_log import RunLog
from remodel_planner.errors import CellError, PlannerError
from remodel_planner.ros.pictures import keep_pictures
from remodel_planner.ros.state_message import levels, state_message
from remodel_planner.ros.use_case_supervisor import Peers, UseCaseSupervisor, Work
from remodel_planner.ros.work import WorkMaker

ACTION = "remodel/run_use_case"
STATE = "remodel/use_case/state"

# [s] wall time between two states, while something runs.
_TELL_EVERY_S = 0.2


@dataclass
class _Active:
    """A run under way.

    Attributes:
        handle: the goal that asked for it; None if it goes on by itself.
        begun: ROS time at which this process took it up.
    """

    supervisor: UseCaseSupervisor
    handle: actionlib.ServerGoalHandle | None
    begun: rospy.Time


class RunServer:
    """Does one run at a time."""

    def __init__(
        self, database: ProductionDatabase, maker: WorkMaker, peers: Peers, cell: str, runs: Path
    ) -> None:
        """Begin to serve, and go on with what was cut short.

        Args:
            database: that has the orders, and keeps the runs.
            maker: makes what a run is about.
            peers: nodes that runs need.
            cell: name of this cell.
            runs: folder of the runs' pictures.
        """
        self._log = RunLog(database)
        self._maker = maker
        self._peers = peers
        self._cell = cell
        self._runs = runs
        self._active: _Active | None = None
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._state = rospy.Publisher(STATE, UseCaseState, latch=True, queue_size=1)
        self._state.publish(
            UseCaseState(stamp=rospy.Time.now(), phase=UseCaseState.IDLE, cell=cell)
        )
        for command in (Command.PAUSE, Command.RESUME, Command.STOP):
            self._serve_run(command)
        for command in (Command.SKIP, Command.RETRY):
            self._serve_task(command)
        rospy.Service("remodel/use_case/answer", AnswerQuestion, self._on_answer)
        self._server = actionlib.ActionServer(
            ACTION, RunUseCaseAction, self._on_goal, self._on_cancel, auto_start=False
        )
        self._server.start()
        threading.Thread(target=self._tell, name="tell", daemon=True).start()
        unfinished = self._log.unfinished(cell)
        if unfinished is not None:
            self._go_on(unfinished)

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = handle.get_goal()
        with self._lock:
            try:
                self._require_sound(goal)
                active = self._begun(goal, handle)
            except PlannerError as error:
                code = ErrorCode.BUSY if self._active else ErrorCode.INVALID_GOAL
                handle.set_rejected(_refusal(goal, code, str(error)), str(error))
                return
            handle.set_accepted()
            self._start(active)

    def _require_sound(self, goal: RunUseCaseGoal) -> None:
        if self._active is not None:
            state = self._active.supervisor.state
            raise CellError(
                f"run {self._active.supervisor.run} of order {state.order} is under way"
            )
        if not goal.id:
            raise CellError("id is empty; it must name the goal")
        if not 0 <= goal.timeout < float("inf"):
            raise CellError(f"timeout must be a number >= 0, found {goal.timeout}")

    def _begun(self, goal: RunUseCaseGoal, handle: actionlib.ServerGoalHandle) -> _Active:
        """Begin a run; PlannerError, and no run, if the order cannot be done."""
        work = self._maker.work(goal.order, goal.tasks, goal.timeout)
        tasks = tuple(task.name for task in work.planner.order.tasks)
        begun = RunBegun(goal.order, work.planner.use_case.name, self._cell, tasks)
        run = self._log.begin(begun, again=goal.again)
        if goal.again:
            work = replace(work, keep_panel=False)
        return self._made(run, work, state_after([begun]), handle)

    def _go_on(self, run: int) -> None:
        """Take up a run that was cut short."""
        state = state_after(kept.event for kept in self._log.events(run))
        rospy.loginfo("going on with run %d of order %s", run, state.order)
        with self._lock:
            work = self._maker.work(state.order, len(state.tasks), 0.0)
            self._start(self._made(run, work, state, None))

    def _made(
        self,
        run: int,
        work: Work,
        state: RunState,
        handle: actionlib.ServerGoalHandle | None,
    ) -> _Active:
        supervisor = UseCaseSupervisor(
            run,
            state,
            self._log,
            work,
            self._peers,
            lambda label, sights: keep_pictures(self._runs / str(run), label, sights),
            self._changed.set,
        )
        return _Active(supervisor, handle, rospy.Time.now())

    def _start(self, active: _Active) -> None:
        self._active = active
        threading.Thread(target=self._do, args=(active,), name="run", daemon=True).start()

    def _do(self, active: _Active) -> None:
        try:
            state = active.supervisor.supervise()
        except Exception as error:  # noqa: BLE001 - a run that nobody does any more must not look alive
            # This node is started again, and goes on with the run.
            rospy.logfatal("run %d: %s", active.supervisor.run, traceback.format_exc())
            rospy.signal_shutdown(str(error))
            return
        self._publish(active)
        with self._lock:
            self._active = None
        if active.handle is not None and state.ended is not None:
            _answer(active, state)

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        active = self._active
        if active is not None and active.handle == handle:
            with contextlib.suppress(CellError):
                active.supervisor.command(Commanded(Command.STOP, "", "the goal's client"))

    def _serve_run(self, command: Command) -> None:
        def on_call(request: object) -> CommandRunResponse:
            return CommandRunResponse(*self._commanded(command, "", request.by))  # type: ignore[attr-defined]

        rospy.Service(f"remodel/use_case/{command.value}", CommandRun, on_call)

    def _serve_task(self, command: Command) -> None:
        def on_call(request: object) -> CommandTaskResponse:
            done = self._commanded(command, request.task, request.by)  # type: ignore[attr-defined]
            return CommandTaskResponse(*done)

        rospy.Service(f"remodel/use_case/{command.value}", CommandTask, on_call)

    def _commanded(self, command: Command, task: str, by: str) -> tuple[bool, str]:
        try:
            self._required().command(Commanded(command, task, by or "somebody"))
        except PlannerError as error:
            return False, str(error)
        return True, ""

    def _on_answer(self, request: object) -> AnswerQuestionResponse:
        number, choice = request.question, request.choice  # type: ignore[attr-defined]
        try:
            if choice not in {answer.value for answer in Answer}:
                raise CellError(
                    f"{choice!r} is no answer; there are {', '.join(a.value for a in Answer)}"
                )
            by = request.by or "somebody"  # type: ignore[attr-defined]
            self._required().answer(Answered(number, Answer(choice), by))
        except PlannerError as error:
            return AnswerQuestionResponse(False, str(error))
        return AnswerQuestionResponse(True, "")

    def _required(self) -> UseCaseSupervisor:
        active = self._active
        if active is None:
            raise CellError("no run is under way")
        return active.supervisor

    def _tell(self) -> None:
        """Publish the state when it has changed, and what the abilities do while they do it."""
        while not rospy.is_shutdown():
            self._changed.wait(_TELL_EVERY_S)
            self._changed.clear()
            active = self._active
            if active is not None:
                with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
                    self._publish(active)
                    _feed_back(active)
                time.sleep(_TELL_EVERY_S / 4)

    def _publish(self, active: _Active) -> None:
        descriptions = self._maker.descriptions
        self._state.publish(state_message(active.supervisor, descriptions, active.begun))


def _feed_back(active: _Active) -> None:
    state = active.supervisor.state
    if active.handle is None or state.ended is not None:
        return
    ended = len(state.in_stage(Stage.DONE, Stage.SET_ASIDE))
    active.handle.publish_feedback(
        RunUseCaseFeedback(
            id=active.handle.get_goal().id,
            message=active.supervisor.doing,
            elapsed_time=(rospy.Time.now() - active.begun).to_sec(),
            completed_percentage=100.0 * ended / max(1, len(state.tasks)),
            task=state.current,
            levels=levels(active.supervisor),
        )
    )


def _answer(active: _Active, state: RunState) -> None:
    """End the goal as the run has ended."""
    done = list(state.in_stage(Stage.DONE))
    left = [name for name in state.tasks if name not in done]
    complete = state.ended is not None and state.ended.ending is Ending.COMPLETE
    because = state.ended.because if state.ended else ""
    result = RunUseCaseResult(
        id=active.handle.get_goal().id,
        success=complete,
        message=f"{len(done)} of {len(state.tasks)} tasks done",
        elapsed_time=(rospy.Time.now() - active.begun).to_sec(),
        error_code=ErrorCode.NONE if complete else ErrorCode.INTERNAL,
        error_message="" if complete else because,
        run=active.supervisor.run,
        done=done,
        left=left,
    )
    if complete:
        active.handle.set_succeeded(result)
    elif state.ended is not None and state.ended.ending is Ending.STOPPED:
        result.error_code = ErrorCode.PREEMPTED
        active.handle.set_canceled(result, because)
    else:
        active.handle.set_aborted(result, because)


def _refusal(goal: RunUseCaseGoal, code: int, text: str) -> RunUseCaseResult:
    return RunUseCaseResult(id=goal.id, success=False, error_code=code, error_message=text)
