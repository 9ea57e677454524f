"""Send goals to action servers, with every wait bounded by wall time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from genpy import Message

from flexbe_core.ros.master import drop_dead
from remodel_production.errors import LostError

# [s] wall time between two checks whether a server is there.
_CHECK_S = 0.02


class ActionServer:
    """An action server, which may be restarted meanwhile.

    On `actionlib.ActionClient`: `SimpleActionClient` loses a status that arrives while it sends.
    """

    def __init__(self, name: str, action: type, node: str) -> None:
        """Connect when it is there.

        Args:
            name: of the action.
            action: its `...Action` class.
            node: that serves it, for the error text.
        """
        self._name = name
        self._node = node
        self._client = actionlib.ActionClient(name, action)

    @property
    def is_there(self) -> bool:
        """Whether the server is connected."""
        if rospy.get_rostime().is_zero():
            return False  # no clock yet: no cell, and actionlib cannot count back from zero
        drop_dead(self._client.pub_goal)
        # To actionlib zero means for ever; what has passed already, one look.
        return self._client.wait_for_server(rospy.Duration(0, -1))

    def wait(self, limit_s: float) -> None:
        """Wait until the server is there, up to a limit of wall time [s].

        Raises:
            LostError: if it is not there in time.
        """
        end = time.monotonic() + limit_s
        while not self.is_there:
            if time.monotonic() > end or rospy.is_shutdown():
                raise LostError(
                    f"action {rospy.resolve_name(self._name)} is not there after {limit_s:.0f} s: "
                    f"start {self._node}"
                )
            time.sleep(_CHECK_S)

    def ended(
        self,
        goal: Message,
        limit_s: float,
        on_feedback: Callable[[Message], None] | None = None,
    ) -> Goal:
        """Send a goal, and return it when it has ended.

        Args:
            goal: to send.
            limit_s: [s] wall time that it gets.
            on_feedback: called with each feedback.

        Raises:
            LostError: if the server is not there, goes away meanwhile, or takes longer; the goal
                is cancelled.
        """
        self.wait(limit_s)
        sent = self.send(goal, on_feedback)
        end = time.monotonic() + limit_s
        while not sent.wait(_CHECK_S):
            if not self.is_there or time.monotonic() > end:
                sent.cancel()
                what = "has gone" if not self.is_there else f"took more than {limit_s:.0f} s"
                raise LostError(f"action {rospy.resolve_name(self._name)}: {self._node} {what}")
        if sent.lost:
            raise LostError(f"action {rospy.resolve_name(self._name)}: the goal is forgotten")
        return sent

    def cancel_all(self) -> None:
        """Ask the server to stop all goals, from all clients."""
        self._client.cancel_all_goals()

    def send(
        self,
        goal: Message,
        on_feedback: Callable[[Message], None] | None = None,
        on_end: Callable[[], None] | None = None,
    ) -> Goal:
        """Send a goal; on_end is called, on a thread of actionlib, when it has ended."""
        ended = threading.Event()

        def on_transition(handle: actionlib.ClientGoalHandle) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE:
                ended.set()
                if on_end is not None:
                    on_end()

        def pass_on(_: actionlib.ClientGoalHandle, feedback: Message) -> None:
            if on_feedback is not None:
                on_feedback(feedback)

        return Goal(self._client.send_goal(goal, on_transition, pass_on), ended)


class Goal:
    """A goal that was sent; cancelled when it is given up."""

    def __init__(self, handle: actionlib.ClientGoalHandle, ended: threading.Event) -> None:
        """Keep the handle; the event is set when the goal has ended."""
        self._handle = handle
        self._ended = ended

    def wait(self, limit_s: float) -> bool:
        """Wait up to a limit of wall time [s]; return whether the goal has ended."""
        return self._ended.wait(limit_s)

    def cancel(self) -> None:
        """Ask the server to stop."""
        self._handle.cancel()

    @property
    def result(self) -> Message | None:
        """The result of a goal that has ended; None if the server sent none."""
        return self._handle.get_result()

    @property
    def succeeded(self) -> bool:
        """Whether the goal has ended well."""
        return self._handle.get_terminal_state() == GoalStatus.SUCCEEDED

    @property
    def lost(self) -> bool:
        """Whether the server does not know the goal (any more)."""
        return self._handle.get_terminal_state() == GoalStatus.LOST

    @property
    def status(self) -> int:
        """The actionlib_msgs/GoalStatus of a goal that has ended."""
        return int(self._handle.get_terminal_state())

    @property
    def text(self) -> str:
        """The server's text at the end of the goal."""
        return str(self._handle.get_goal_status_text())

    @property
    def ending(self) -> str:
        """How the goal has ended, in words: the status, and the server's text."""
        status = GoalStatus.to_string(self._handle.get_terminal_state()).lower()
        text = self._handle.get_goal_status_text()
        return f"{status}: {text}" if text else status
