"""Publish what a use case supervisor does, in little: a small state, and what changes in the tasks.

All tasks are returned by a service, which clients call when they join or have missed a change.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import rospy
from remodel_msgs.msg import UseCaseChanges, UseCaseState
from remodel_msgs.srv import GetTasks, GetTasksRequest, GetTasksResponse

from remodel_supervision.core.runs.changes import all_decisions, changes_between, in_plan_order
from remodel_supervision.ros.server.run_messages import (
    RunView,
    failure_message,
    hand_wire_message,
    levels,
    state_message,
    task_message,
)

__all__ = ["RunView", "StatePublisher", "levels"]

STATE = "remodel/use_case/state"
CHANGES = "remodel/use_case/changes"
TASKS = "remodel/use_case/tasks"

# [s] wall time between two publications of a run; and after which the state is published though
# nothing has changed, so that clients notice a supervisor that hangs.
_INTERVAL_S = 0.25
_HEARTBEAT_S = 1.0

# Changes that wait for a slow subscriber; one that loses some gets all tasks again.
_QUEUE_SIZE = 100


@dataclass(frozen=True)
class _Published:
    """What clients know: the run as it was published last.

    Attributes:
        order: names of the tasks, as they were planned last.
        number: of the last changes in their series.
    """

    view: RunView
    series: int
    number: int
    order: tuple[str, ...]


class StatePublisher:
    """Publishes state and changes of the run under way, and serves its tasks.

    `publish`, `flush` and `idle` are called from one thread, the service from others.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Advertise the topics and the service; `clock` returns wall time [s]."""
        self._clock = clock
        self._state = rospy.Publisher(STATE, UseCaseState, latch=True, queue_size=1)
        self._changes = rospy.Publisher(CHANGES, UseCaseChanges, queue_size=_QUEUE_SIZE)
        self._lock = threading.Lock()
        self._published: _Published | None = None
        self._waiting: RunView | None = None
        self._last = UseCaseState()
        self._sent_s = self._compared_s = -_HEARTBEAT_S
        rospy.Service(TASKS, GetTasks, self._on_get)

    def idle(
        self,
        cell: str,
        text: str = "",
        *,
        starting: bool = False,
        stopped_by: str = "",
        controllers: Sequence[str] = (),
    ) -> None:
        """Publish that there is no run.

        How a run has ended stays published, and its tasks served, as long as there is nothing to
        report about the supervisor itself.

        Args:
            cell: name of this cell.
            text: why, for a person; empty if it waits for an order.
            starting: an order cannot be taken yet.
            stopped_by: who has stopped the cell protectively; empty if it is not stopped.
            controllers: those of them that are safety controllers.
        """
        has_ended = self._published is not None and self._published.view.state.ended is not None
        if has_ended and not text and not starting:
            return
        with self._lock:
            self._published = self._waiting = None
        phase = UseCaseState.STARTING if starting else UseCaseState.IDLE
        phase = UseCaseState.PROTECTIVE_STOP if stopped_by else phase
        self._send(
            UseCaseState(
                phase=phase,
                cell=cell,
                message=text,
                stopped_by=stopped_by,
                controllers=list(controllers),
            )
        )

    def publish(self, view: RunView) -> None:
        """Publish what has changed in a run, now or with the next `flush` that is due.

        The beginning and the end of a run are published at once.
        """
        before = self._published
        is_edge = (
            before is None
            or before.view.run != view.run
            or (before.view.state.ended is None and view.state.ended is not None)
        )
        self._waiting = view
        if is_edge or self._due_in_s() <= 0:
            self._publish_waiting()

    def flush(self) -> float:
        """Publish what waits for its time, and repeat the state now and then.

        Returns:
            Wall time [s] after which there will be something to publish, if nothing changes.
        """
        if self._waiting is not None and self._due_in_s() <= 0:
            self._publish_waiting()
        if self._due_in_s() <= 0:
            self._send(self._last)
        return max(0.0, self._due_in_s())

    def _due_in_s(self) -> float:
        """Return the wall time until the next publication is due; below 0 if it is overdue [s]."""
        is_waiting = self._waiting is not None
        due_s = self._compared_s + _INTERVAL_S if is_waiting else self._sent_s + _HEARTBEAT_S
        return due_s - self._clock()

    def _publish_waiting(self) -> None:
        view, self._waiting = self._waiting, None
        assert view is not None, "only called when a view waits"
        message = state_message(view)
        changes = self._take(view)
        message.series, message.changes = self._published.series, self._published.number
        if changes is not None:
            self._changes.publish(changes)
        message.stamp, self._compared_s = self._last.stamp, self._clock()
        if changes is not None or message != self._last:
            self._send(message)

    def _take(self, view: RunView) -> UseCaseChanges | None:
        """Replace what the service returns, and return what has changed; None if nothing has."""
        before = self._published
        if before is None or before.view.run != view.run:
            published = _Published(view, time.time_ns(), 0, in_plan_order(view.state))
            with self._lock:
                self._published = published
            return None
        changed = changes_between(before.view.state, view.state)
        number = before.number + bool(changed)
        order = in_plan_order(view.state, before.order) if changed.replanned else before.order
        with self._lock:
            self._published = _Published(view, before.series, number, order)
        if not changed:
            return None
        return UseCaseChanges(
            run=view.run,
            series=before.series,
            number=number,
            replanned=changed.replanned,
            tasks=[task_message(view, name) for name in changed.tasks],
            failures=[failure_message(decision) for decision in changed.decisions],
        )

    def _send(self, message: UseCaseState) -> None:
        message.stamp = rospy.Time.now()
        self._last, self._sent_s = message, self._clock()
        self._state.publish(message)

    def _on_get(self, request: GetTasksRequest) -> GetTasksResponse:
        with self._lock:
            published = self._published
        if published is None or request.run not in (0, published.view.run):
            asked = f"run {request.run}" if request.run else "a run"
            return GetTasksResponse(success=False, message=f"this supervisor does not have {asked}")
        view, first = published.view, max(1, request.first)
        end = first - 1 + request.count if request.count else None
        decisions = all_decisions(view.state) if first == 1 else ()
        by_hand = view.state.by_hand if first == 1 else ()
        return GetTasksResponse(
            success=True,
            run=view.run,
            series=published.series,
            number=published.number,
            total=len(published.order),
            tasks=[task_message(view, name) for name in published.order[first - 1 : end]],
            failures=[failure_message(decision) for decision in decisions],
            by_hand=[hand_wire_message(wire) for wire in by_hand],
        )
