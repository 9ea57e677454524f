"""Inspecting what of a task is done: the ability CheckConnection."""

from __future__ import annotations

import uuid

from remodel_msgs.msg import CheckConnectionAction, CheckConnectionGoal

from remodel_supervision.ros.action_server import ActionServer
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.supervisors.ports import UnseenError

ACTION = "remodel_abilities/checkconnection"

# [s] ROS time that an inspection gets, and wall time after which its server counts as lost.
_TIMEOUT_S = 30.0
_LIMIT_S = 120.0

# remodel_msgs/ErrorCode.INTERNAL, of an answer that there is not.
_INTERNAL = 5


class Inspection:
    """Inspects terminals."""

    def __init__(self, loop: RosEventLoop) -> None:
        """Connect when the ability is there."""
        self._loop = loop
        self._server = ActionServer(ACTION, CheckConnectionAction, "the cell (remodel_sim cell)")

    def wait(self, limit_s: float) -> None:
        """Wait for the ability, up to a limit of wall time [s]; LostError if it does not come."""
        self._loop.background(lambda: self._server.wait(limit_s))

    def is_connected(self, owner: int, wire: str, end: str, component: str, terminal: str) -> bool:
        """Return whether an end ("a" or "b") of a wire is in a terminal.

        Args:
            owner: token of the supervisor that asks.
            wire: its name.
            end: letter.
            component: of the terminal.
            terminal: of the component.

        Raises:
            UnseenError: if it could not be seen.
            LostError: if the ability is lost.
        """
        goal = CheckConnectionGoal(
            id=f"{owner}:check {wire} {end} {uuid.uuid4().hex[:8]}",
            cable_id=wire,
            cable_end=end,
            component_id=component,
            terminal_id=terminal,
            timeout=_TIMEOUT_S,
        )
        sent = self._loop.background(lambda: self._server.ended(goal, _LIMIT_S))
        result = sent.result
        if result is None or not result.success:
            code = result.error_code if result else _INTERNAL
            text = result.error_message if result else sent.ending
            raise UnseenError(code or _INTERNAL, text, goal.id)
        return bool(result.connected)
