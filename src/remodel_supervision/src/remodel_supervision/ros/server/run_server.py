"""The use case supervisor's node: takes goals, and supervises one run at a time.

The run under way is published by topics, to the client of its goal, and to the states.
"""

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

from flexbe_core.ros.master import SteadyActionServer
from remodel_production.edge.database.cell_ownership import CellOwnership
from remodel_production.errors import PlannerError, RecordLostError
from remodel_run.progress import sums_words
from remodel_supervision.core.runs.events import Command, Commanded, Ending
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.core.runs.sums import sums_of
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.errors import CellError
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.ros.server.run_services import RunServices
from remodel_supervision.ros.server.state_publisher import RunView, StatePublisher, levels
from remodel_supervision.ros.server.work import WorkMaker
from remodel_supervision.supervisors.cell_runs import CellRuns, OwnedCell
from remodel_supervision.supervisors.ports import Peers
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor


@dataclass
class ActiveRun:
    """A run under way.

    Attributes:
        handle: the goal that asked for it; None if it was resumed.
        begun: ROS time at which this process began or resumed it.
    """

    supervisor: UseCaseSupervisor
    handle: actionlib.ServerGoalHandle | None
    begun: rospy.Time

    def feed_back(self, view: RunView) -> None:
        """Publish feedback of the goal, if it came from one."""
        state = self.supervisor.state
        if self.handle is None or state.ended is not None:
            return
        ended = len(state.in_stage(Stage.DONE, Stage.SET_ASIDE))
        self.handle.publish_feedback(
            RunUseCaseFeedback(
                id=self.handle.get_goal().id,
                message=self.supervisor.doing,
                elapsed_time=(rospy.Time.now() - self.begun).to_sec(),
                completed_percentage=100.0 * ended / max(1, len(state.tasks)),
                task=state.current,
                levels=levels(view),
            )
        )

    def answer(self, state: RunState) -> None:
        """End the goal, if it came from one, as the run has ended."""
        if self.handle is None:
            return
        result = self._result()
        because = state.ended.because if state.ended else ""
        result.success = state.ended is not None and state.ended.ending is Ending.COMPLETE
        if result.success:
            self.handle.set_succeeded(result)
            return
        result.error_code, result.error_message = ErrorCode.INTERNAL, because
        if state.ended is not None and state.ended.ending is Ending.STOPPED:
            result.error_code = ErrorCode.PREEMPTED
            self.handle.set_canceled(result, because)
        else:
            self.handle.set_aborted(result, because)

    def abort(self, because: str) -> None:
        """End the goal, if it came from one, since this supervisor gives the run up."""
        if self.handle is None:
            return
        result = self._result()
        result.error_code, result.error_message = ErrorCode.STALE_OWNER, because
        self.handle.set_aborted(result, because)

    def _result(self) -> RunUseCaseResult:
        assert self.handle is not None, "only called with a goal"
        state = self.supervisor.state
        done = list(state.in_stage(Stage.DONE))
        return RunUseCaseResult(
            id=self.handle.get_goal().id,
            message=sums_words(sums_of(state)),
            elapsed_time=(rospy.Time.now() - self.begun).to_sec(),
            run=self.supervisor.run,
            done=done,
            left=[name for name in state.tasks if name not in done],
        )


def refusal(goal: RunUseCaseGoal, code: int, text: str) -> RunUseCaseResult:
    """Return the result of a goal that is rejected."""
    return RunUseCaseResult(id=goal.id, success=False, error_code=code, error_message=text)


# [s] wall time between two publications.
_PUBLISH_EVERY_S = 0.25


class RunPublication:
    """Publishes what happens to the runs of a cell; see RunObserver.

    Attributes:
        active: the run under way; None without one.
    """

    def __init__(
        self, loop: RosEventLoop, maker: WorkMaker, peers: Peers, services: RunServices
    ) -> None:
        """Publish that this node is starting.

        Args:
            loop: on which everything is done.
            maker: makes what a run is about.
            peers: processes that runs need.
            services: by which states reach the run under way.
        """
        self.active: ActiveRun | None = None
        self._maker = maker
        self._peers = peers
        self._services = services
        # The goal of a run that has not begun, by the run's number.
        self._goals: dict[int, actionlib.ServerGoalHandle] = {}
        self._publisher = StatePublisher()
        self._publisher.idle(maker.cell, starting=True)
        loop.every(_PUBLISH_EVERY_S, self._publish)

    def expect(self, supervisor: UseCaseSupervisor, handle: actionlib.ServerGoalHandle) -> None:
        """Note the goal that asked for a run; its client is answered when the run has ended."""
        self._goals[supervisor.run] = handle

    def on_idle(self, text: str, *, starting: bool) -> None:
        """Publish that there is no run, and log why none can begin."""
        if starting:
            rospy.logerr("%s", text)
        commands = self._services.commands
        by = "" if starting else commands.stopped_by
        self._publisher.idle(
            self._maker.cell,
            text,
            starting=starting,
            stopped_by=by,
            controllers=commands.controllers,
        )

    def on_resume(self, run: int, state: RunState) -> None:
        """Log that a run is about to be resumed."""
        rospy.loginfo("resuming run %d of order %s", run, state.order)

    def on_begin(self, supervisor: UseCaseSupervisor) -> None:
        """Have all states ask this supervisor before they begin."""
        handle = self._goals.pop(supervisor.run, None)
        self.active = ActiveRun(supervisor, handle, rospy.Time.now())
        self._services.ask_to_be_asked()

    def on_change(self) -> None:
        """Publish what has changed in the run under way."""
        if self.active is not None:
            self._publisher.publish(self._view(self.active))

    def on_end(self, supervisor: UseCaseSupervisor) -> None:
        """Publish how the run under way has ended, and answer the client of its goal."""
        self._services.ask_no_more()
        self.on_change()
        active, self.active = self.active, None
        assert active is not None, "only called during a run"
        active.answer(supervisor.state)

    def on_give_up(self, error: PlannerError) -> None:
        """Answer the client of the goal why its run is not supervised any more."""
        if self.active is not None:
            self.active.abort(str(error))
        self.active = None
        if isinstance(error, RecordLostError):
            self._services.ask_no_more()

    def _publish(self) -> None:
        with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
            self._publisher.flush()
            if self.active is not None:
                self.on_change()
                self.active.feed_back(self._view(self.active))

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
            controllers=self._services.commands.controllers,
            moving=supervisor.is_moving,
        )


ACTION = "remodel/run_use_case"

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
        self._loop = loop
        services = RunServices(loop, peers.abilities)
        self._commands = services.commands
        self._publication = RunPublication(loop, maker, peers, services)
        self._runs = CellRuns(
            OwnedCell(maker.cell, ownership, loop),
            loop,
            log,
            maker,
            peers=peers,
            commands=self._commands,
            observer=self._publication,
        )
        self._server = SteadyActionServer(
            ACTION,
            RunUseCaseAction,
            lambda handle: loop.post(lambda: self._on_goal(handle)),
            lambda handle: loop.post(lambda: self._on_cancel(handle)),
            auto_start=False,
        )
        self._server.start()
        self._thread = threading.Thread(target=self._serve, name="supervisor", daemon=True)
        self._thread.start()
        rospy.on_shutdown(self.close)

    def close(self) -> None:
        """Stop what moves, and end; the run goes on when the node is started again."""
        self._loop.leave()
        if threading.current_thread() is not self._thread:
            self._thread.join(_LEAVE_LIMIT_S)

    def _serve(self) -> None:
        try:
            self._runs.serve()
        except Exception as error:  # noqa: BLE001 - an unsupervised run must not look alive
            # roslaunch respawns this node, which resumes the run.
            rospy.logfatal("%s", traceback.format_exc())
            rospy.signal_shutdown(str(error))

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = handle.get_goal()
        code = ErrorCode.BUSY
        try:
            self._runs.require_free()
            code = ErrorCode.INVALID_GOAL
            _require_sound(goal)
            supervisor = self._runs.begin(
                goal.order, goal.tasks, goal.timeout, use_case=goal.use_case, again=goal.again
            )
        except PlannerError as error:
            handle.set_rejected(refusal(goal, code, str(error)), str(error))
            return
        self._publication.expect(supervisor, handle)
        handle.set_accepted()

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        active = self._publication.active
        if active is not None and active.handle == handle:
            stop = Commanded(Command.STOP, "", "the goal's client")
            active.supervisor.command(stop, lambda granted, text: None)


def _require_sound(goal: RunUseCaseGoal) -> None:
    if not goal.id:
        raise CellError("id is empty; it must name the goal")
    if not 0 <= goal.timeout < float("inf"):
        raise CellError(f"timeout must be a number >= 0, found {goal.timeout}")
