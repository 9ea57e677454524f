"""The use case supervisor's node: owns its cell, takes goals, and supervises one run at a time."""

from __future__ import annotations

import contextlib
import threading
import traceback

import actionlib
import rospy
from remodel_msgs.msg import (
    ErrorCode,
    RunUseCaseAction,
    RunUseCaseGoal,
)

from flexbe_core.ros.steady_action_server import SteadyActionServer
from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.errors import LostError, OwnerError, PlannerError, RecordLostError
from remodel_supervision.core.runs.events import Command, Commanded, RunBegun
from remodel_supervision.core.runs.fold import state_after
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.errors import CellError, LeavingError
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.ros.server.active_run import ActiveRun, refusal
from remodel_supervision.ros.server.run_messages import RunView
from remodel_supervision.ros.server.run_services import RunServices
from remodel_supervision.ros.server.state_publisher import StatePublisher
from remodel_supervision.ros.server.work import WorkMaker
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.unresumed_run import UnresumedRun
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor
from remodel_supervision.supervisors.work import Peers, Work

ACTION = "remodel/run_use_case"

# [s] wall time between two attempts to own the cell, and between two publications.
_ACQUIRE_EVERY_S = 1.0
_PUBLISH_EVERY_S = 0.25

# [s] wall time that a run gets to come to rest when the node is shut down; roslaunch waits for 15.
_LEAVE_LIMIT_S = 8.0


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
        self._active: ActiveRun | None = None
        self._next: ActiveRun | None = None
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
            by = self._services.commands.stopped_by
            self._publisher.idle(self._maker.cell, self._closed, stopped_by=by)
            self._loop.run_until(lambda: is_over() or is_outdated(), float("inf"))

    def _resume(self) -> None:
        """Take the cell's run to its end that was cut short, or begun without an answer."""
        unfinished = self._log.unfinished(self._maker.cell)
        self._unsure = False
        active = None if unfinished is None else self._resumed(unfinished)
        if active is not None:
            self._supervise(active)

    def _resumed(self, run: int) -> ActiveRun | None:
        """Return a run that was cut short, taken up; None if a person is needed, and has acted."""
        self._log.take_up(run, self._owner)
        state = self._log.state(run)
        rospy.loginfo("resuming run %d of order %s", run, state.order)
        try:
            work = self._maker.work(state.order, len(state.tasks), self._owner)
        except (LostError, OwnerError, RecordLostError):
            raise
        except PlannerError as error:
            self._await_person(UnresumedRun(run, self._owner, state, self._log, str(error)))
            return None
        return self._made(run, state, work, None)

    def _await_person(self, unresumed: UnresumedRun) -> None:
        """Keep a run that cannot be resumed, and refuse goals, until a person has acted."""
        rospy.logerr("%s", unresumed.text)
        self._peers.engine.cancel()
        self._peers.abilities.cancel()
        self._closed = unresumed.text
        self._publisher.idle(self._maker.cell, self._closed, starting=True)
        self._services.commands.unresumed = unresumed
        try:
            self._loop.run_until(lambda: unresumed.is_over or bool(self._disowned), float("inf"))
        finally:
            self._services.commands.unresumed = None
        self._unsure = True
        if self._disowned:
            raise OwnerError(self._disowned)

    def _made(
        self, run: int, state: RunState, work: Work, handle: actionlib.ServerGoalHandle | None
    ) -> ActiveRun:
        supervisor = UseCaseSupervisor(
            RunRecord(run, self._owner, state, self._log, loop=self._loop),
            self._loop,
            work,
            self._peers,
            on_change=self._on_change,
            disowned=self._why_disowned,
        )
        return ActiveRun(supervisor, handle, rospy.Time.now())

    def _supervise(self, active: ActiveRun) -> None:
        self._active, self._next = active, None
        self._services.ask_to_be_asked()
        self._services.commands.stop_if_unsafe()
        self._on_change()
        try:
            state = active.supervisor.supervise()
        except (OwnerError, RecordLostError) as error:
            active.abort(str(error))
            raise
        self._services.ask_no_more()
        self._on_change()
        self._active = None
        active.answer(state)

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
            handle.set_rejected(refusal(goal, code, str(error)), str(error))
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

    def _begun(self, goal: RunUseCaseGoal, handle: actionlib.ServerGoalHandle) -> ActiveRun:
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
                self._active.feed_back(self._view(self._active))

    def _view(self, active: ActiveRun) -> RunView:
        supervisor = active.supervisor
        return RunView(
            run=supervisor.run,
            state=supervisor.state,
            doing=supervisor.doing,
            doing_now=self._peers.abilities.latest,
            state_path=self._peers.engine.state_path,
            started=active.begun,
            expected_s=supervisor.work.planner.expected_s,
            descriptions=self._maker.descriptions,
            moving=supervisor.is_moving,
        )
