"""Run behaviors as an action: flexbe/execute_behavior.

How goals end:

    the behavior is unknown, a file value cannot be read    REJECTED, with a text
    it finishes                                             SUCCEEDED, outcome
    it is cancelled, or stopped otherwise                   PREEMPTED, outcome 'preempted'
    it fails                                                ABORTED, "failed: ..."
    the engine does not start it                            ABORTED, "not started: ..."
    the engine is missing, stops, stalls or restarts        ABORTED, "engine lost: ..."
    this node is shut down                                  ABORTED, "action server ended: ..."

When a stalled engine responds again, the server stops the behavior that was given up before it
starts another one. A goal that arrives while another runs stops that one and waits for its end; it
replaces a goal that is already waiting.

ROS callbacks only put events into a queue. One thread handles them all.
"""

from __future__ import annotations

import queue
import threading
import time
import traceback
from dataclasses import dataclass

import actionlib
import rospy
from flexbe_msgs.msg import (
    BehaviorExecutionAction,
    BehaviorExecutionFeedback,
    BehaviorExecutionResult,
    BehaviorSelection,
)

from flexbe_core import BehaviorLibrary
from flexbe_core.behavior import paired
from flexbe_core.engine.supervision import PREEMPTED, StatusCode
from flexbe_core.ros.master import SteadyActionServer
from flexbe_widget.core.run_watch import (
    ENGINE_LOST_TEXT,
    FAILED_TEXT,
    NOT_STARTED_TEXT,
    SERVER_ENDED_TEXT,
    SILENCE_S,
    START_LIMIT_S,
    Ending,
    RunEnd,
    RunWatch,
    is_busy,
)
from flexbe_widget.ros.engine_link import EngineLink, Entered, Status
from flexbe_widget.ros.request_server import start_request

# [s] Wall time between two checks of the time limits.
_CHECK_EVERY_S = 0.1

# [s] Wall time that a goal waits for an engine.
_ENGINE_LIMIT_S = 10.0


# How a run ended -> the method of the goal's handle that ends it, and a text.
_ENDS = {
    RunEnd.FINISHED: ("set_succeeded", ""),
    RunEnd.PREEMPTED: ("set_canceled", "{name!r} was stopped"),
    RunEnd.FAILED: ("set_aborted", FAILED_TEXT + "{name!r}: {why}"),
    RunEnd.REFUSED: ("set_aborted", NOT_STARTED_TEXT + "{name!r}: {why}"),
    RunEnd.LATE: ("set_aborted", NOT_STARTED_TEXT + f"{{name!r}} within {START_LIMIT_S:g} s"),
    RunEnd.RESTARTED: ("set_aborted", ENGINE_LOST_TEXT + "it was restarted during {name!r}"),
    RunEnd.LOST: ("set_aborted", ENGINE_LOST_TEXT + f"it has been silent for {SILENCE_S:g} s"),
}


@dataclass(frozen=True)
class _NewGoal:
    handle: actionlib.ServerGoalHandle


@dataclass(frozen=True)
class _Cancelled:
    handle: actionlib.ServerGoalHandle


@dataclass
class _Run:
    """A goal that has not ended.

    Attributes:
        handle: the goal.
        request: the request to the engine.
        since: [s] when it arrived.
        watch: follows the run; None until the request has been sent.
        older: statuses up to this number were sent before the request.
        is_stopping: whether it is to be stopped.
    """

    handle: actionlib.ServerGoalHandle
    request: BehaviorSelection
    since: float
    watch: RunWatch | None = None
    older: int = 0
    is_stopping: bool = False


class BehaviorActionServer:
    """Serves flexbe/execute_behavior."""

    def __init__(self) -> None:
        self._library = BehaviorLibrary()
        self._events: queue.SimpleQueue[object] = queue.SimpleQueue()
        self._link = EngineLink(self._events.put)
        self._run: _Run | None = None
        self._next: _Run | None = None
        self._given_up: RunWatch | None = None
        self._server = SteadyActionServer(
            "flexbe/execute_behavior",
            BehaviorExecutionAction,
            lambda handle: self._events.put(_NewGoal(handle)),
            lambda handle: self._events.put(_Cancelled(handle)),
            auto_start=False,
        )
        self._server.start()
        rospy.on_shutdown(self._abort)
        threading.Thread(target=self._work, name="goals", daemon=True).start()

    def _work(self) -> None:
        while not rospy.is_shutdown():
            try:
                event = self._events.get(timeout=_CHECK_EVERY_S if self._run else None)
            except queue.Empty:
                event = None
            try:
                self._handle(event)
            except Exception as error:  # noqa: BLE001 - without this thread no goal would end
                rospy.logerr("%s", traceback.format_exc())
                if self._run is not None:
                    self._link.preempt()
                    self._finish(self._run, "set_aborted", "", f"internal error: {error}")

    def _handle(self, event: object) -> None:
        if isinstance(event, _NewGoal):
            self._on_goal(event.handle)
        elif isinstance(event, _Cancelled):
            self._on_cancel(event.handle)
        elif isinstance(event, Status) and self._given_up is not None:
            self._stop_given_up(self._given_up, event)
        run = self._run
        if run is None:
            return
        if run.watch is None:
            self._ask(run)
        elif isinstance(event, Entered):
            run.handle.publish_feedback(BehaviorExecutionFeedback(event.path))
        elif isinstance(event, Status):
            if event.number > run.older:
                self._on_status(run, run.watch, event)
        else:
            waited_s = time.monotonic() - run.since
            self._end(run, run.watch.on_time(waited_s, self._link.silent_s()))

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = handle.get_goal()
        try:
            request = start_request(
                self._library,
                goal.behavior_name,
                paired(goal.arg_keys, goal.arg_values),
                paired(goal.input_keys, goal.input_values),
            )
        except Exception as error:  # noqa: BLE001 - a RequestError, or else the goal must end too
            rospy.logerr("goal rejected: %s", error)
            rospy.logdebug("%s", traceback.format_exc())
            handle.set_rejected(BehaviorExecutionResult(), str(error))
            return
        if self._next is not None:
            self._next.handle.set_canceled(BehaviorExecutionResult(), "replaced by a later goal")
        self._next = _Run(handle, request, time.monotonic())
        if self._run is None:
            self._begin_next()
        else:
            self._stop(self._run)

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        run = self._run
        if self._next is not None and handle == self._next.handle:
            self._next = None
            handle.set_canceled(BehaviorExecutionResult(), "cancelled before it was started")
        elif run is not None and handle == run.handle:
            self._stop(run)

    def _begin_next(self) -> None:
        self._run, self._next = self._next, None
        if self._run is not None:
            self._run.handle.set_accepted()
            self._run.since = time.monotonic()

    def _ask(self, run: _Run) -> None:
        """Send the request, as soon as the engine is there and has stopped what was given up."""
        if self._link.is_there and self._given_up is None:
            run.watch = RunWatch(run.request.behavior_checksum)
            run.older = self._link.start(run.request)
        elif time.monotonic() - run.since > _ENGINE_LIMIT_S:
            self._given_up = None
            text = (
                f"{ENGINE_LOST_TEXT}none is there and free after {_ENGINE_LIMIT_S:g} s; "
                "start it with: roslaunch flexbe_onboard behavior_onboard.launch"
            )
            self._finish(run, "set_aborted", "", text)

    def _on_status(self, run: _Run, watch: RunWatch, status: Status) -> None:
        was_running = watch.is_running
        ending = watch.on_status(status.code, status.behavior_id, status.args)
        if run.is_stopping and watch.is_running and not was_running:
            self._link.preempt()
        self._end(run, ending)

    def _stop_given_up(self, given_up: RunWatch, status: Status) -> None:
        """Stop a run that continues although it was given up; forget it once the engine is free.

        A preempt that the engine receives before the start request has no effect: they arrive on
        separate connections.
        """
        given_up.on_status(status.code, status.behavior_id, status.args)
        if not is_busy(status.code) or not given_up.concerns(status.behavior_id):
            self._given_up = None
        elif status.code == StatusCode.STARTED:
            self._link.preempt()

    def _stop(self, run: _Run) -> None:
        """Stop the behavior, now or as soon as it runs; without a request yet, it never runs."""
        if run.watch is None:
            self._end(run, Ending(RunEnd.PREEMPTED, PREEMPTED))
        elif not run.is_stopping:
            run.is_stopping = True
            if run.watch.is_running:
                self._link.preempt()

    def _end(self, run: _Run, ending: Ending | None) -> None:
        """End the goal, if its run has ended."""
        if ending is None:
            return
        if ending.end in (RunEnd.LATE, RunEnd.LOST):
            self._link.preempt()
        if ending.end is RunEnd.LOST:
            self._given_up = run.watch
        method, text = _ENDS[ending.end]
        why = self._link.why() if "{why}" in text else ""
        name = run.handle.get_goal().behavior_name
        self._finish(run, method, ending.outcome, text.format(name=name, why=why))

    def _finish(self, run: _Run, method: str, outcome: str, text: str) -> None:
        getattr(run.handle, method)(BehaviorExecutionResult(outcome), text)
        self._run = None
        self._begin_next()

    def _abort(self) -> None:
        """End all goals when the node is shut down, so that no client waits."""
        for run in (self._run, self._next):
            if run is not None:
                text = f"{SERVER_ENDED_TEXT}the behavior continues in the engine"
                run.handle.set_aborted(BehaviorExecutionResult(), text)
