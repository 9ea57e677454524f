"""Looking what of a task is done: the ability CheckConnection."""

from __future__ import annotations

import uuid

from remodel_msgs.msg import CheckConnectionAction, CheckConnectionGoal

from remodel_planner.ros.action_server import ActionServer

ACTION = "remodel_abilities/checkconnection"

# [s] ROS time that a look gets, and wall time after which its server counts as lost.
_TIMEOUT_S = 30.0
_LIMIT_S = 120.0

# remodel_msgs/ErrorCode.INTERNAL, of an answer that there is not.
_INTERNAL = 5


class UnseenError(Exception):
    """It could not be seen.

    Attributes:
        code: remodel_msgs/ErrorCode.
    """

    def __init__(self, code: int, text: str) -> None:
        """Keep the code and the reason."""
        super().__init__(text)
        self.code = code


class Inspection:
    """Looks at terminals."""

    def __init__(self) -> None:
        """Connect when the ability is there."""
        self._server = ActionServer(ACTION, CheckConnectionAction, "the cell (remodel_sim cell)")

    def wait(self, limit_s: float) -> None:
        """Wait for the ability, up to a limit of wall time [s]; LostError if it does not come."""
        self._server.wait(limit_s)

    def is_connected(self, wire: str, end: str, component: str, terminal: str) -> bool:
        """Return whether an end ("a" or "b") of a wire sits in a terminal.

        Raises:
            UnseenError: if it could not be seen.
            LostError: if the ability is lost.
        """
        goal = CheckConnectionGoal(
            id=f"check {wire} {end} {uuid.uuid4().hex[:8]}",
            cable_id=wire,
            cable_end=end,
            component_id=component,
            terminal_id=terminal,
            timeout=_TIMEOUT_S,
        )
        sent = self._server.ended(goal, _LIMIT_S)
        result = sent.result
        if result is None or not result.success:
            code = result.error_code if result else _INTERNAL
            raise UnseenError(code or _INTERNAL, result.error_message if result else sent.ending)
        return bool(result.connected)
