"""The use case supervisor's node: takes goals, and supervises one run at a time."""

from __future__ import annotations

import threading
import traceback

import actionlib
import rospy
from remodel_msgs.msg import ErrorCode, RunUseCaseAction, RunUseCaseGoal

from flexbe_core.ros.master import SteadyActionServer
from remodel_production.edge.database.cell_ownership import CellOwnership
from remodel_production.errors import PlannerError
from remodel_supervision.core.runs.events import Command, Commanded
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.errors import CellError
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.ros.server.run_publication import RunPublication, refusal
from remodel_supervision.ros.server.run_services import RunServices
from remodel_supervision.ros.server.work import WorkMaker
from remodel_supervision.supervisors.cell.cell_runs import CellRuns
from remodel_supervision.supervisors.cell.owned_cell import OwnedCell
from remodel_supervision.supervisors.ports import Peers

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
