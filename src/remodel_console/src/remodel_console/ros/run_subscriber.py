"""Follow the run of a use case supervisor: its state, the changes of its tasks, and all tasks."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import rospy
from remodel_msgs import msg, srv

from remodel_console.core.use_case.task_copy import TaskCopy
from remodel_console.core.use_case.use_case import UseCase
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service
from remodel_console.ros.run_values import changes_of, snapshot_of, use_case_of

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
