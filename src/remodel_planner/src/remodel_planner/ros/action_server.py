"""Send goals to action servers, with every wait bounded by wall time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from genpy import Message

from remodel_planner.errors import CellError

# [s] wall time for a server's node to come up.
START_LIMIT_S = 60.0


class ActionServer:
    """An action server that is there.

    On `actionlib.ActionClient`: `SimpleActionClient` loses a status that arrives while it sends.
    """

    def __init__(self, name: str, action: type, node: str) -> None:
        """Connect.

        Args:
            name: of the action.
            action: its `...Action` class.
            node: that serves it, for the error text.

        Raises:
            CellError: if the server is not there in time.
        """
        self._client = actionlib.ActionClient(name, action)
        limit = time.monotonic() + START_LIMIT_S
        while time.monotonic() < limit and not rospy.is_shutdown():
            if self._client.wait_for_server(rospy.Duration(0.5)):
                return
        raise CellError(
            f"action {rospy.resolve_name(name)} is not there after {START_LIMIT_S:.0f} s: "
            f"start {node}"
        )

    def send(self, goal: Message, on_feedback: Callable[[Message], None] | None = None) -> Goal:
        """Send a goal."""
        ended = threading.Event()

        def on_transition(handle: actionlib.ClientGoalHandle) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE:
                ended.set()

        def tell(_: actionlib.ClientGoalHandle, feedback: Message) -> None:
            if on_feedback is not None:
                on_feedback(feedback)

        return Goal(self._client.send_goal(goal, on_transition, tell), ended)


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
    def ending(self) -> str:
        """How the goal has ended, in words: the status, and the server's text."""
        status = GoalStatus.to_string(self._handle.get_terminal_state()).lower()
        text = self._handle.get_goal_status_text()
        return f"{status}: {text}" if text else status
