"""The use case supervisor's node: owns its cell, takes goals, and supervises one run at a time."""

from __future__ import annotations

import contextlib
import threading
import traceback
from dataclasses import dataclass

import actionlib
import rospy
from remodel_msgs.msg import (
    ErrorCode,
    RunUseCaseAction,
    RunUseCaseFeedback,
    RunUseCaseGoal,
    RunUseCaseResult,
)

from flexbe_core.ros.steady_action_server import SteadyActionServer
from remodel_planner.core.supervision.events import Command, Commanded, Ending, RunBegun
from remodel_planner.core.supervision.fold import state_after
from remodel_planner.core.supervision.state import RunState, Stage
from remodel_planner.edge.cell_ownership import CellOwnership, Owned
from remodel_planner.edge.run_log import RunLog
from remodel_planner.errors import (
    CellError,
    LeavingError,
    LostError,
    OwnerError,
    PlannerError,
    RecordLostError,
)
from remodel_planner.ros.event_loop import RosEventLoop
from remodel_planner.ros.run_messages import RunView, levels
from remodel_planner.ros.run_services import RunServices
from remodel_planner.ros.state_publisher import StatePublisher
from remodel_planner.ros.work import WorkMaker
from remodel_planner.supervisors.use_case_supervisor import UseCaseSupervisor
from remodel_planner.supervisors.work import Peers

ACTION = "remodel/run_use_case"

# [s] wall time between two attempts to own the cell, and between two publications.
_ACQUIRE_EVERY_S = 1.0
_PUBLISH_EVERY_S = 0.25

# [s] wall time that a run gets to come to rest when the node is shut down; roslaunch waits for 15.
_LEAVE_LIMIT_S = 8.0


@dataclass
class _Active:
    """A run under way.

    Attributes:
        handle: the goal that asked for it; None if it was resumed.
        begun: ROS time at which this process began or resumed it.
    """

    supervisor: UseCaseSupervisor
    handle: actionlib.ServerGoalHandle | None
    begun: rospy.Time


class RunServer:
    """Supervises runs, one at a time, on a thread of its own."""

    def __init__(
        self,
        log: RunLog,
        maker: WorkMaker,
        peers: Peers,
        ownership: CellOwnership,
        loop: RosEventLoop,
    ) -> None:
        """Begin to serve; a run that was cut short is resumed before any goal is taken.

        Args:
            log: keeps the runs.
            maker: makes what a run is about.
            peers: processes that runs need.
            ownership: of the cell.
            loop: on which everything is done.
        """
        self._log = log
        self._maker = maker
        self._peers = peers
        self._ownership = ownership
        self._loop = loop
        self._owner = 0
        self._owned_until_s = 0.0
        self._disowned = ""
        # Whether the cell may have a run that has not ended and that nobody supervises.
        self._unsure = True
        self._closed = "this node is starting; ask again"
        self._active: _Active | None = None
        self._next: _Active | None = None
        self._publisher = StatePublisher()
        self._publisher.idle(maker.cell, self._closed, starting=True)
        self._services = RunServices(
            loop, lambda: self._supervisor, self._why_closed, peers.abilities
        )
        self._server = SteadyActionServer(
            ACTION,
            RunUseCaseAction,
            lambda handle: loop.post(lambda: self._on_goal(handle)),
            lambda handle: loop.post(lambda: self._on_cancel(handle)),
            auto_start=False,
        )
        self._server.start()
        loop.every(_PUBLISH_EVERY_S, self._publish)
        loop.every(ownership.lease_s / 3, self._renew)
        self._thread = threading.Thread(target=self._serve, name="supervisor", daemon=True)
        self._thread.start()
        rospy.on_shutdown(self.close)

    def close(self) -> None:
        """Stop what moves, and end; the run goes on when the node is started again."""
        self._loop.leave()
        if threading.current_thread() is not self._thread:
            self._thread.join(_LEAVE_LIMIT_S)

    @property
    def _supervisor(self) -> UseCaseSupervisor | None:
        return self._active.supervisor if self._active else None

    def _why_closed(self) -> str:
        """Return why nothing new is taken; empty if this node is idle, or supervises a run."""
        return self._closed

    # --- the thread

    def _serve(self) -> None:
        try:
            while True:
                self._acquire()
                try:
                    self._supervise_runs()
                except (OwnerError, RecordLostError) as error:
                    self._give_up(error)
        except LeavingError:
            self._release()
        except Exception as error:  # noqa: BLE001 - a run that nobody supervises must not look alive
            # roslaunch respawns this node, which resumes the run.
            rospy.logfatal("%s", traceback.format_exc())
            rospy.signal_shutdown(str(error))

    def _acquire(self) -> None:
        """Own the cell; until it can be owned, publish why not, and wait."""
        while True:
            asked_s = self._loop.wall_s()
            try:
                found = self._ownership.acquire()
                if isinstance(found, Owned):
                    break
                text = (
                    f"cell {self._maker.cell} is owned by another station: {found.holder}; stop "
                    "that one, or give this cell a name of its own (cell_name:=)"
                )
            except (LostError, RecordLostError) as error:
                text = str(error)
            if text != self._closed:
                rospy.logerr("%s", text)
                self._publisher.idle(self._maker.cell, text, starting=True)
            self._closed = text
            self._loop.run_until(lambda: False, _ACQUIRE_EVERY_S)
        self._owner = found.token
        self._owned_until_s = asked_s + self._ownership.lease_s
        self._disowned = ""

    def _renew(self) -> None:
        if not self._owner:
            return
        asked_s = self._loop.wall_s()
        with contextlib.suppress(LostError):
            if not self._ownership.renew(self._owner):
                self._disowned = f"another supervisor owns cell {self._maker.cell} now"
                return
            self._owned_until_s = asked_s + self._ownership.lease_s

    def _why_disowned(self) -> str:
        """Return why this supervisor does not own the cell, for all that it knows."""
        if not self._disowned and self._loop.wall_s() > self._owned_until_s:
            return (
                f"the ownership of cell {self._maker.cell} could not be renewed: the production "
                "database does not answer"
            )
        return self._disowned

    def _supervise_runs(self) -> None:
        self._unsure = True
        while True:
            if self._unsure:
                self._resume()
            self._await_goal()
            if self._next is not None:
                self._supervise(self._next)
            elif not self._unsure:
                raise OwnerError(self._disowned)

    def _await_goal(self) -> None:
        """Return when there is a goal, or none can be taken before something else is done."""

        def is_over() -> bool:
            return self._next is not None or self._unsure or bool(self._disowned)

        def is_outdated() -> bool:
            return self._closed != self._services.commands.safety

        while not is_over():
            self._closed = self._services.commands.safety
            self._publisher.idle(self._maker.cell, self._closed)
            self._loop.run_until(lambda: is_over() or is_outdated(), float("inf"))

    def _resume(self) -> None:
        """Take the cell's run to its end that was cut short, or begun without an answer."""
        unfinished = self._log.unfinished(self._maker.cell)
        self._unsure = False
        if unfinished is not None:
            self._supervise(self._resumed(unfinished))

    def _resumed(self, run: int) -> _Active:
        """Return a run that was cut short, taken up."""
        self._log.take_up(run, self._owner)
        state = self._log.state(run)
        rospy.loginfo("resuming run %d of order %s", run, state.order)
        work = self._maker.work(state.order, len(state.tasks), self._owner)
        return self._made(run, state, work, None)

    def _made(
        self, run: int, state: RunState, work: object, handle: actionlib.ServerGoalHandle | None
    ) -> _Active:
        supervisor = UseCaseSupervisor(
            run,
            self._owner,
            state,
            self._loop,
            self._log,
            work,  # type: ignore[arg-type]
            self._peers,
            self._on_change,
            self._why_disowned,
        )
        return _Active(supervisor, handle, rospy.Time.now())

    def _supervise(self, active: _Active) -> None:
        self._active, self._next = active, None
        self._services.ask_to_be_asked()
        self._services.commands.stop_if_unsafe()
        self._on_change()
        try:
            state = active.supervisor.supervise()
        except (OwnerError, RecordLostError) as error:
            if active.handle is not None:
                _abort(active, str(error))
            raise
        self._services.ask_no_more()
        self._on_change()
        self._active = None
        if active.handle is not None:
            _answer(active, state)

    def _give_up(self, error: PlannerError) -> None:
        """Report why the run under way is not supervised any more."""
        rospy.logerr("%s", error)
        self._active, self._owner = None, 0
        self._closed = str(error)
        self._publisher.idle(self._maker.cell, self._closed, starting=True)
        if isinstance(error, RecordLostError):
            self._services.ask_no_more()
            self._loop.run_until(lambda: False, _ACQUIRE_EVERY_S)

    def _release(self) -> None:
        with contextlib.suppress(PlannerError):
            if self._owner:
                self._ownership.release(self._owner)

    # --- goals

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = handle.get_goal()
        try:
            self._require_sound(goal)
            self._next = self._begun(goal, handle)
        except PlannerError as error:
            if isinstance(error, OwnerError):
                self._disowned = str(error)
            is_busy = self._active is not None or bool(self._closed)
            code = ErrorCode.BUSY if is_busy else ErrorCode.INVALID_GOAL
            handle.set_rejected(_refusal(goal, code, str(error)), str(error))
            return
        handle.set_accepted()

    def _require_sound(self, goal: RunUseCaseGoal) -> None:
        active = self._active or self._next
        if active is not None:
            run = active.supervisor
            raise CellError(f"run {run.run} of order {run.state.order} is under way")
        if self._closed:
            raise CellError(self._closed)
        if not goal.id:
            raise CellError("id is empty; it must name the goal")
        if not 0 <= goal.timeout < float("inf"):
            raise CellError(f"timeout must be a number >= 0, found {goal.timeout}")

    def _begun(self, goal: RunUseCaseGoal, handle: actionlib.ServerGoalHandle) -> _Active:
        """Begin a run; PlannerError, and no run, if the order cannot be done."""
        work = self._maker.work(goal.order, goal.tasks, self._owner)
        tasks = tuple(task.name for task in work.planner.order.tasks)
        begun = RunBegun(
            goal.order,
            work.planner.use_case.name,
            self._maker.cell,
            tasks,
            timeout_s=goal.timeout,
        )
        try:
            run, begun = self._log.begin(begun, self._owner, again=goal.again)
        except LostError as error:
            self._unsure = True
            raise LostError(f"{error}; if the run was begun nevertheless, it is done") from error
        return self._made(run, state_after([begun]), work, handle)

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        active = self._active
        if active is not None and active.handle == handle:
            stop = Commanded(Command.STOP, "", "the goal's client")
            active.supervisor.command(stop, lambda granted, text: None)

    # --- publications

    def _on_change(self) -> None:
        if self._active is not None:
            self._publisher.publish(self._view(self._active))

    def _publish(self) -> None:
        with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
            self._publisher.flush()
            if self._active is not None:
                self._on_change()
                self._feed_back(self._active)

    def _view(self, active: _Active) -> RunView:
        supervisor = active.supervisor
        return RunView(
            run=supervisor.run,
            state=supervisor.state,
            doing=supervisor.doing,
            doing_now=supervisor.doing_now,
            state_path=supervisor.state_path,
            started=active.begun,
            expected_s=supervisor.work.planner.expected_s,
            descriptions=self._maker.descriptions,
            moving=supervisor.is_moving,
        )

    def _feed_back(self, active: _Active) -> None:
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
                levels=levels(self._view(active)),
            )
        )


def _answer(active: _Active, state: RunState) -> None:
    """End the goal as the run has ended."""
    result = _result(active, state)
    because = state.ended.because if state.ended else ""
    result.success = state.ended is not None and state.ended.ending is Ending.COMPLETE
    if result.success:
        active.handle.set_succeeded(result)
        return
    result.error_code, result.error_message = ErrorCode.INTERNAL, because
    if state.ended is not None and state.ended.ending is Ending.STOPPED:
        result.error_code = ErrorCode.PREEMPTED
        active.handle.set_canceled(result, because)
    else:
        active.handle.set_aborted(result, because)


def _abort(active: _Active, because: str) -> None:
    result = _result(active, active.supervisor.state)
    result.error_code, result.error_message = ErrorCode.STALE_OWNER, because
    active.handle.set_aborted(result, because)


def _result(active: _Active, state: RunState) -> RunUseCaseResult:
    done = list(state.in_stage(Stage.DONE))
    return RunUseCaseResult(
        id=active.handle.get_goal().id,
        message=f"{len(done)} of {len(state.tasks)} tasks done",
        elapsed_time=(rospy.Time.now() - active.begun).to_sec(),
        run=active.supervisor.run,
        done=done,
        left=[name for name in state.tasks if name not in done],
    )


def _refusal(goal: RunUseCaseGoal, code: int, text: str) -> RunUseCaseResult:
    return RunUseCaseResult(id=goal.id, success=False, error_code=code, error_message=text)
