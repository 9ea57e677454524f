"""The synthesis action server, as the use case supervisor asks it."""

from __future__ import annotations

from pathlib import Path

from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisGoal,
    SynthesisErrorCodes,
    SynthesisRequest,
)

from flexbe_synthesizer.core.chart.model import Chart
from remodel_supervision.edge.known_behaviors import describes
from remodel_supervision.errors import CellError
from remodel_supervision.ros.action_server import ActionServer
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_tasks.core.task_charts.task_chart import content_mark
from remodel_tasks.edge.chart_folder import keep_chart

ACTION = "flexbe/synthesize"

# [s] wall time for one chart; the FlexBE App gives up after 10 s.
LIMIT_S = 10.0


class BehaviorSynthesizer:
    """Has behaviors made of charts."""

    def __init__(self, loop: RosEventLoop, charts: Path) -> None:
        """Connect when the server is there; `charts` is a folder that it may read."""
        self._loop = loop
        self._charts = charts
        self._server = ActionServer(ACTION, BehaviorSynthesisAction, "synthesis_server")

    def wait(self, limit_s: float) -> None:
        """Wait for the server, up to a limit of wall time [s]; LostError if it does not come."""
        self._loop.background(lambda: self._server.wait(limit_s))

    def make(self, chart: Chart) -> None:
        """Have the behavior of a chart made, unless it exists with the same content.

        Raises:
            CellError: with the server's own words if it refuses.
            LostError: if it does not answer.
            InstanceError: if the chart's file cannot be written.
        """
        chart_file, _ = keep_chart(chart, self._charts)
        if not describes(chart.name, content_mark(chart)):
            self._loop.background(lambda: self.synthesize(str(chart_file), chart.name))

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
