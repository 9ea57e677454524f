"""The synthesis action server, as the use case supervisor asks it."""

from __future__ import annotations

import threading

from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisGoal,
    SynthesisErrorCodes,
    SynthesisRequest,
)

from remodel_planner.errors import CellError
from remodel_planner.ros.action_server import connect

ACTION = "flexbe/synthesize"

# [s] wall time for one chart; the FlexBE App gives up after 10 s.
LIMIT_S = 10.0


class BehaviorSynthesizer:
    """Has charts made into behaviors."""

    def __init__(self) -> None:
        """Connect to the server; CellError if it is not there in time."""
        self._client = connect(ACTION, BehaviorSynthesisAction, "synthesis_server")

    def synthesize(self, chart_file: str, behavior: str) -> None:
        """Have the behavior of a chart written where the engine finds it.

        Args:
            chart_file: absolute path, inside the server's chart folders.
            behavior: its name.

        Raises:
            CellError: with the server's own words if it refuses or does not answer.
        """
        done = threading.Event()
        said: list[str] = []

        def on_feedback(feedback: BehaviorSynthesisFeedback) -> None:
            said.append(feedback.status)

        request = SynthesisRequest(name=f"/{behavior}", goal=chart_file)
        self._client.send_goal(
            BehaviorSynthesisGoal(request=request),
            done_cb=lambda *_: done.set(),
            feedback_cb=on_feedback,
        )
        if not done.wait(LIMIT_S):
            self._client.cancel_goal()
            raise CellError(f"synthesis of {chart_file} took more than {LIMIT_S:.0f} s")
        result = self._client.get_result()
        if result is None or result.error_code.value != SynthesisErrorCodes.SUCCESS:
            text = self._client.get_goal_status_text() or (said[-1] if said else "no reason given")
            raise CellError(f"synthesis of {chart_file} failed: {text}")
