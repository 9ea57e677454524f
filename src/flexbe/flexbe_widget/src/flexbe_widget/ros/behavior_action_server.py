"""Run behaviors as an action: flexbe/execute_behavior.

How goals end:

    the behavior is unknown, a file value cannot be read    REJECTED, with a text
    it finishes                                             SUCCEEDED, outcome
    it is cancelled, or stopped otherwise                   PREEMPTED, outcome 'preempted'
    it fails, is not started, the engine goes away          ABORTED, with a text

A goal that comes while another runs stops that one and waits for its end; one that waits already is
dropped for it.

Callbacks of ROS only put events into a queue. One thread takes them out and does everything.
"""

from __future__ import annotations

import queue
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass

import actionlib
import rospy
from flexbe_msgs.msg import (
    BehaviorExecutionAction,
    BehaviorExecutionFeedback,
    BehaviorExecutionResult,
    BehaviorSelection,
)
from genpy import Message

from flexbe_core import BehaviorLibrary
from flexbe_widget.core.run_watch import START_LIMIT_S, End, Ending, RunWatch
from flexbe_widget.edge.value_file import resolved
from flexbe_widget.errors import RequestError
from flexbe_widget.ros.engine_link import EngineLink, Entered, Status
from flexbe_widget.ros.start_request import start_request

Handle = actionlib.ServerGoalHandle

# [s] Wall time between two looks at what takes too long.
_LOOK_EVERY_S = 0.5

# [s] Wall time that a goal waits for an engine.
_ENGINE_LIMIT_S = 10.0


@dataclass(frozen=True)
class _NewGoal:
    handle: Handle


@dataclass(frozen=True)
class _Cancelled:
    handle: Handle


@dataclass
class _Run:
    """A goal on its way.

    Attributes:
        handle: the goal.
        request: what the engine is asked for.
        since: [s] when it came.
        watch: how it goes; None until the engine has been asked.
        is_stopping: whether it is to be stopped.
    """

    handle: Handle
    request: BehaviorSelection
    since: float
    watch: RunWatch | None = None
    is_stopping: bool = False


class BehaviorActionServer:
    """Serves flexbe/execute_behavior."""

    def __init__(self) -> None:
        """Begin to serve."""
        self._library = BehaviorLibrary()
        self._events: queue.SimpleQueue[object] = queue.SimpleQueue()
        self._link = EngineLink(self._events.put)
        self._run: _Run | None = None
        self._next: _Run | None = None
        self._server = actionlib.ActionServer(
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
                event = self._events.get(timeout=_LOOK_EVERY_S if self._run else None)
            except queue.Empty:
                event = None
            try:
                self._handle(event)
            except Exception as error:  # noqa: BLE001 - without this thread no goal would end
                rospy.logerr("%s", traceback.format_exc())
                if self._run is not None:
                    self._finish(self._run.handle.set_aborted, "", f"internal error: {error}")

    def _handle(self, event: object) -> None:
        if isinstance(event, _NewGoal):
            self._on_goal(event.handle)
        elif isinstance(event, _Cancelled):
            self._on_cancel(event.handle)
        elif isinstance(event, Entered) and self._run and self._run.watch:
            self._run.handle.publish_feedback(BehaviorExecutionFeedback(event.path))
        if self._run is None:
            return
        if self._run.watch is None:
            self._ask()
        elif isinstance(event, Status):
            self._on_status(self._run, event)
        else:
            waited_s = time.monotonic() - self._run.since
            self._end(self._run.watch.on_time(waited_s, self._link.silent_s()))

    def _on_goal(self, handle: Handle) -> None:
        goal = handle.get_goal()
        try:
            request = start_request(
                self._library,
                goal.behavior_name,
                [(k, resolved(v)) for k, v in zip(goal.arg_keys, goal.arg_values, strict=False)],
                [
                    (k, resolved(v))
                    for k, v in zip(goal.input_keys, goal.input_values, strict=False)
                ],
            )
        except RequestError as error:
            rospy.logerr("goal rejected: %s", error)
            handle.set_rejected(BehaviorExecutionResult(), str(error))
            return
        if self._next is not None:
            self._next.handle.set_canceled(BehaviorExecutionResult(), "another goal came behind it")
        self._next = _Run(handle, request, time.monotonic())
        if self._run is None:
            self._begin_next()
        else:
            self._stop(self._run)

    def _on_cancel(self, handle: Handle) -> None:
        if self._next is not None and handle == self._next.handle:
            self._next = None
            handle.set_canceled(BehaviorExecutionResult(), "cancelled before it was started")
        elif self._run is not None and handle == self._run.handle:
            if self._run.watch is None:
                self._end(Ending(End.PREEMPTED, "preempted"))
            else:
                self._stop(self._run)

    def _begin_next(self) -> None:
        self._run, self._next = self._next, None
        if self._run is not None:
            self._run.handle.set_accepted()
            self._run.since = time.monotonic()

    def _ask(self) -> None:
        """Ask the engine, as soon as it is there."""
        run = self._run
        if self._link.is_there:
            run.watch = RunWatch(run.request.behavior_checksum)
            self._link.start(run.request)
        elif time.monotonic() - run.since > _ENGINE_LIMIT_S:
            self._finish(
                run.handle.set_aborted,
                "",
                f"no behavior engine for {_ENGINE_LIMIT_S:g} s; "
                "start it with: roslaunch flexbe_onboard behavior_onboard.launch",
            )

    def _on_status(self, run: _Run, status: Status) -> None:
        was_running = run.watch.is_running
        ending = run.watch.on_status(status.code, status.behavior_id, status.args)
        if run.is_stopping and run.watch.is_running and not was_running:
            self._link.preempt()
        self._end(ending)

    def _stop(self, run: _Run) -> None:
        """Stop the behavior, now or as soon as it runs."""
        if not run.is_stopping:
            run.is_stopping = True
            if run.watch is not None and run.watch.is_running:
                self._link.preempt()

    def _end(self, ending: Ending | None) -> None:
        """End the goal, if its run has ended."""
        if ending is None:
            return
        if ending.end is End.LATE:
            self._link.preempt()
        name = self._run.handle.get_goal().behavior_name
        why = self._link.why() if ending.end in (End.FAILED, End.REFUSED) else ""
        handle = self._run.handle
        act, text = {
            End.FINISHED: (handle.set_succeeded, ""),
            End.PREEMPTED: (handle.set_canceled, f"{name!r} was stopped"),
            End.FAILED: (handle.set_aborted, f"{name!r} failed: {why}"),
            End.REFUSED: (handle.set_aborted, f"{name!r} was not started: {why}"),
            End.LATE: (handle.set_aborted, f"{name!r} is not started after {START_LIMIT_S:g} s"),
            End.RESTARTED: (handle.set_aborted, "the behavior engine was started anew"),
            End.LOST: (handle.set_aborted, "the behavior engine gives no sign of life"),
        }[ending.end]
        self._finish(act, ending.outcome, text)

    def _abort(self) -> None:
        """Leave no client waiting when the node is shut down."""
        for run in (self._run, self._next):
            if run is not None:
                text = "be_action_server was shut down; what runs in the engine goes on"
                run.handle.set_aborted(BehaviorExecutionResult(), text)

    def _finish(self, act: Callable[[Message, str], None], outcome: str, text: str) -> None:
        act(BehaviorExecutionResult(outcome), text)
        self._run = None
        self._begin_next()
