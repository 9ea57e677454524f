"""The base of all ability servers: it keeps the contract of all abilities for its subclasses.

    class CrimpFerrule(AbilityServer):

        def check(self, goal):
            if goal.ferrule_id not in FERRULES:
                raise AbilityError(ErrorCode.UNKNOWN_NAME, f"no ferrule {goal.ferrule_id!r}")

        def perform(self, running):
            running.report("closing the jaw", 20.0)
            running.wait(0.5)
            return Done("crimped", {"height": 0.002})

What it does with a goal (first row that holds):

    an empty id, no timeout, NaN or infinity       rejected   INVALID_GOAL
    older than its timeout, or than 5 s            rejected   INVALID_GOAL
    a field beyond the limits of the cell          rejected   INVALID_GOAL
    a newer supervisor owns the robot              rejected   STALE_OWNER
    the robot is doing another goal                rejected   BUSY
    `check` raises an AbilityError                 rejected   its code
    `perform` returns                              succeeded
    `perform` raises an AbilityError               aborted    its code
    cancelled (`wait` and `check` raise it)        preempted  PREEMPTED
    its timeout has passed (they raise it too)     aborted    TIMEOUT
    any other exception                            aborted    INTERNAL, or rejected if in `check`

A subclass that does not do its goals in threads overrides `prepare` and `start` instead.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import rospy
from actionlib import ServerGoalHandle
from actionlib_msgs.msg import GoalStatus
from genpy import Message
from remodel_msgs.msg import ErrorCode

from flexbe_core.ros.master import SteadyActionServer
from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import beyond_limit, limits_of, owner_of
from remodel_states.core.tables import Ability, TableError
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.serving import Robot, RunningGoal, message_class, why_invalid, why_late


@dataclass(frozen=True)
class Done:
    """What an ability did.

    Attributes:
        message: for a person.
        found: fields of the result.
    """

    message: str
    found: Mapping[str, Any] = field(default_factory=dict)


OnHandle = Callable[[ServerGoalHandle], None]


class Host(Protocol):
    """Where abilities are served."""

    def limits(self) -> object:
        """Return the document of the cell's limits (core/contract.py)."""

    def serve(
        self, topic: str, action_type: type[Message], on_goal: OnHandle, on_cancel: OnHandle
    ) -> object:
        """Serve an action as long as what is returned is kept."""


class RosHost:
    """Serves over ROS."""

    def limits(self) -> object:
        """Return parameter /remodel/limits."""
        return rospy.get_param("/remodel/limits", {})

    def serve(
        self, topic: str, action_type: type[Message], on_goal: OnHandle, on_cancel: OnHandle
    ) -> object:
        """Start an action server."""
        server = SteadyActionServer(topic, action_type, on_goal, on_cancel, auto_start=False)
        server.start()
        return server


class AbilityServer:
    """Serves one ability.

    Attributes:
        limits: of the cell for this ability, by name: parameter /remodel/limits when it started.
    """

    def __init__(
        self,
        ability: str | Ability = "",
        robot: Robot | None = None,
        topic: str = "",
        host: Host | None = None,
    ) -> None:
        """Start to serve.

        Args:
            ability: its name in a table of abilities, or its row; the name of the class by default.
            robot: servers that move the same robot share one; by default it is this server's own.
            topic: of the action; the usual one by default.
            host: where it is served; over ROS by default.

        Raises:
            TableError: if there is no such ability, or its messages are not built; or if the limits
                are malformed.
        """
        self.ability = _row(ability or type(self).__name__)
        host = host or RosHost()
        self.limits = limits_of(self.ability.name, host.limits())
        self._robot = robot or Robot()
        self._result = message_class(self.ability, "Result")
        self._running: dict[str, RunningGoal] = {}
        self._server = host.serve(
            topic or self.ability.topic,
            message_class(self.ability, "Action"),
            lambda handle: self.schedule(lambda: self._take(handle)),
            self._on_cancel,
        )

    def check(self, goal: Message) -> None:
        """Return if a goal can be done; nothing may move.

        Raises:
            AbilityError: if not: which field, what was found, what is allowed.
        """

    def perform(self, running: RunningGoal) -> Done:
        """Do a goal, in a thread of its own; call `wait` or `check` of it every 0.2 s at least.

        Raises:
            AbilityError: if the ability fails.
        """
        raise NotImplementedError

    def schedule(self, take: Callable[[], None]) -> None:
        """Have a new goal taken, at once; override it for servers that live in another thread."""
        take()

    def prepare(self, goal: Message) -> Any:  # noqa: ANN401 - a subclass's own
        """Return what `start` needs to do a valid goal.

        Raises:
            AbilityError: if it cannot be done.
        """
        self._robot.begin(owner_of(goal.id))
        try:
            self.check(goal)
        except BaseException:
            self._robot.end()
            raise

    def start(self, running: RunningGoal, prepared: Any) -> None:  # noqa: ANN401 - likewise
        """Begin to do a goal that was accepted, and return."""
        threading.Thread(target=self._perform, args=(running,), daemon=True).start()

    def cancel(self, running: RunningGoal) -> None:
        """Stop a goal that a client cancels."""
        running.cancel()

    def finish(self, running: RunningGoal, end: Callable[[], None]) -> None:
        """Forget a goal and end it by a call of its `succeed` or `fail`."""
        # In place, since another goal may be taken in another thread.
        for key, other in [*self._running.items()]:
            if other is running:
                self._running.pop(key, None)
        end()

    def elapsed(self) -> Callable[[], float] | None:
        """Return a clock of a goal that begins now; None for `/clock`."""
        return None

    def _take(self, handle: ServerGoalHandle) -> None:
        goal = handle.get_goal()
        if handle.get_goal_status().status == GoalStatus.RECALLING:
            handle.set_canceled(self._refusal(goal, ErrorCode.PREEMPTED, "cancelled"), "cancelled")
            return
        try:
            sent = handle.get_goal_id().stamp
            late = why_late(sent.to_sec(), rospy.get_time(), goal.timeout)
            if reason := why_invalid(goal) or late or beyond_limit(goal, self.limits):
                raise AbilityError(ErrorCode.INVALID_GOAL, reason)
            prepared = self.prepare(goal)
        except AbilityError as error:
            self._refuse(handle, error.code, str(error))
            return
        except Exception as error:  # noqa: BLE001 - the server must live on
            rospy.logerr("%s: %s", self.ability.name, traceback.format_exc())
            self._refuse(handle, ErrorCode.INTERNAL, f"{type(error).__name__}: {error}")
            return
        running = RunningGoal(self.ability, handle, self.elapsed())
        self._running[handle.get_goal_id().id] = running
        handle.set_accepted()
        self.start(running, prepared)
        if handle.get_goal_status().status == GoalStatus.PREEMPTING:
            self._on_cancel(handle)  # a client cancelled it before it was known

    def _on_cancel(self, handle: ServerGoalHandle) -> None:
        running = self._running.get(handle.get_goal_id().id)
        if running is not None:
            self.cancel(running)

    def _perform(self, running: RunningGoal) -> None:
        end = self._end_of(running)
        # Before the answer is out: the next goal may follow at once.
        self._robot.end()
        self.finish(running, end)

    def _end_of(self, running: RunningGoal) -> Callable[[], None]:
        """Do a goal, and return how it ends."""
        try:
            done = self.perform(running)
            if unknown := done.found.keys() - set(self._result.__slots__):
                raise AttributeError(f"the result has no field {', '.join(sorted(unknown))}")
        except AbilityError as error:
            failure = error
        except Exception as error:  # noqa: BLE001 - a goal must end whatever happens
            rospy.logerr("%s: %s", self.ability.name, traceback.format_exc())
            text = f"{type(error).__name__}: {error}; the log has more"
            failure = AbilityError(ErrorCode.INTERNAL, text)
        else:
            return lambda: running.succeed(done.message, done.found)
        return lambda: running.fail(failure.code, str(failure), failure.found)

    def _refuse(self, handle: ServerGoalHandle, code: int, text: str) -> None:
        goal, name = handle.get_goal(), self.ability.name
        rospy.logwarn("%s (goal %r) refused: %d: %s", name, goal.id, code, text)
        handle.set_rejected(self._refusal(goal, code, text), text)

    def _refusal(self, goal: Message, code: int, text: str) -> Message:
        return self._result(id=goal.id, error_code=int(code), error_message=text)


def _row(ability: str | Ability) -> Ability:
    """Return the row of an ability.

    Raises:
        TableError: if there is none of this name.
    """
    if isinstance(ability, Ability):
        return ability
    rows = read_abilities()
    if ability not in rows:
        raise TableError(ability, [f"no such ability; there are: {', '.join(rows)}"])
    return rows[ability]
