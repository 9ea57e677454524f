"""The synthesis action server, as the use case supervisor asks it."""

from __future__ import annotations

from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisGoal,
    SynthesisErrorCodes,
    SynthesisRequest,
)

from remodel_planner.errors import CellError
from remodel_planner.ros.action_server import ActionServer

ACTION = "flexbe/synthesize"

# [s] wall time for one chart; the FlexBE App gives up after 10 s.
LIMIT_S = 10.0


class BehaviorSynthesizer:
    """Has charts made into behaviors."""

    def __init__(self) -> None:
        """Connect when the server is there."""
        self._server = ActionServer(ACTION, BehaviorSynthesisAction, "synthesis_server")

    def wait(self, limit_s: float) -> None:
        """Wait for the server, up to a limit of wall time [s]; LostError if it does not come."""
        self._server.wait(limit_s)

    def synthesize(self, chart_file: str, behavior: str) -> None:
        """Have the behavior of a chart written where the engine finds it.

        Args:
            chart_file: absolute path, inside the server's chart folders.
            behavior: its name.

        Raises:
            CellError: with the server's own words if it refuses.
            LostError: if it does not answer.
        """
        said: list[str] = []

        def on_feedback(feedback: BehaviorSynthesisFeedback) -> None:
            said.append(feedback.status)

        request = SynthesisRequest(name=f"/{behavior}", goal=chart_file)
        goal = self._server.ended(BehaviorSynthesisGoal(request=request), LIMIT_S, on_feedback)
        result = goal.result
        if result is None or result.error_code.value != SynthesisErrorCodes.SUCCESS:
            reason = said[-1] if said else goal.ending
            raise CellError(f"synthesis of {chart_file} failed: {reason}")
