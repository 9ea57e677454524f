"""The action servers beside the supervisor, as it uses them: engine, synthesizer, inspection."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable
from pathlib import Path

import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorExecutionAction,
    BehaviorExecutionGoal,
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisGoal,
    BEStatus,
    SynthesisErrorCodes,
    SynthesisRequest,
)
from remodel_msgs.msg import CheckConnectionAction, CheckConnectionGoal
from rospy import AnyMsg
from std_msgs.msg import Empty, String

from flexbe_synthesizer.core.chart.model import Chart
from remodel_production.errors import LostError
from remodel_supervision.edge.known_behaviors import describes
from remodel_supervision.errors import CellError
from remodel_supervision.ros.action_server import ActionServer, Goal
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind, UnseenError
from remodel_tasks.core.task_charts.task_chart import content_mark
from remodel_tasks.edge.document_files import keep_chart

SYNTHESIS_ACTION = "flexbe/synthesize"

# [s] wall time for one chart; the FlexBE App gives up after 10 s.
SYNTHESIS_LIMIT_S = 10.0


class BehaviorSynthesizer:
    """Has behaviors made of charts."""

    def __init__(self, loop: RosEventLoop, charts: Path) -> None:
        """Connect when the server is there; `charts` is a folder that it may read."""
        self._loop = loop
        self._charts = charts
        self._server = ActionServer(SYNTHESIS_ACTION, BehaviorSynthesisAction, "synthesis_server")

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
        goal = self._server.ended(
            BehaviorSynthesisGoal(request=request), SYNTHESIS_LIMIT_S, on_feedback
        )
        result = goal.result
        if result is None or result.error_code.value != SynthesisErrorCodes.SUCCESS:
            reason = said[-1] if said else goal.ending
            raise CellError(f"synthesis of {chart_file} failed: {reason}")


class Peer:
    """A node that publishes a topic."""

    def __init__(
        self,
        title: str,
        topic: str,
        kind: type = AnyMsg,
        on_message: Callable[[object], None] | None = None,
    ) -> None:
        """Subscribe to its topic.

        Args:
            title: of the node, for errors.
            topic: that it alone publishes.
            kind: of the topic's messages.
            on_message: called with each message.
        """
        self._title = title
        self._subscriber = rospy.Subscriber(topic, kind, on_message or (lambda _: None))

    @property
    def is_there(self) -> bool:
        """Whether it is connected."""
        return self._subscriber.get_num_connections() > 0

    @property
    def trouble(self) -> str:
        """Why the node counts as gone; empty if it is connected."""
        if self.is_there:
            return ""
        return f"{self._title} is gone: nothing publishes {self._subscriber.resolved_name}"


EXECUTION_ACTION = "flexbe/execute_behavior"

# With these words be_action_server begins the status text of a goal whose engine was lost, stalled
# or restarted, or that it gives up itself (flexbe_widget/core/run_watch.py).
_LOST = ("engine lost: ", "action server ended: ")

# [s] wall time without a sign of the engine, which sends a heartbeat each second, after which it
# counts as lost; and after which it does not count as answering.
SILENCE_LIMIT_S = 15
_FRESH_S = 3

# What the engine reports while a behavior runs.
_RUNNING = (BEStatus.STARTED, BEStatus.SWITCHING, BEStatus.LOCKED, BEStatus.WAITING)


class EngineLink:
    """Starts behaviors, one at a time, and watches the engine."""

    def __init__(self, loop: RosEventLoop) -> None:
        """Listen to the engine and its action server."""
        self.state_path = ""
        self._loop = loop
        self._path: list[str] = []
        self._code = BEStatus.READY
        self._silent_s: int | None = None
        self._goal: Goal | None = None
        self._server = ActionServer(EXECUTION_ACTION, BehaviorExecutionAction, "be_action_server")
        self._preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=10)
        self._engine = Peer("the engine", "flexbe/heartbeat", Empty, lambda _: self._on_sign())
        self._runner = Peer("the engine's action server", f"{EXECUTION_ACTION}/feedback")
        rospy.Subscriber("flexbe/status", BEStatus, self._on_status)
        rospy.Subscriber("flexbe/behavior_update", String, self._on_entered, tcp_nodelay=True)
        # Counted, not measured: while this process itself is stopped, no other one is silent.
        loop.every(1.0, self._count_silence)

    @property
    def end(self) -> BehaviorEnd | None:
        """How the behavior started last has ended; None while it runs."""
        goal = self._goal
        if goal is None or not goal.wait(0.0):
            return None
        if goal.succeeded:
            return BehaviorEnd(EndKind.FINISHED, goal.result.outcome)
        text = goal.ending
        if goal.status in (GoalStatus.PREEMPTED, GoalStatus.RECALLED):
            return BehaviorEnd(EndKind.PREEMPTED, text)
        if goal.lost:
            return BehaviorEnd(EndKind.LOST, "the engine's action server lost the behavior")
        is_lost = goal.status == GoalStatus.ABORTED and goal.text.startswith(_LOST)
        return BehaviorEnd(
            EndKind.LOST if is_lost else EndKind.FAILED, goal.text if is_lost else text
        )

    @property
    def trouble(self) -> str:
        """Why engine or action server count as lost; empty if they do not."""
        for peer in (self._engine, self._runner):
            if peer.trouble:
                return peer.trouble
        silent_s = self._silent_s or 0
        if silent_s > SILENCE_LIMIT_S:
            return f"the engine has been silent for {silent_s} s; see its log"
        return ""

    @property
    def is_idle(self) -> bool:
        """Whether the engine has reported lately that it runs no behavior."""
        return self._code not in _RUNNING and self._is_fresh

    def wait(self, limit_s: float) -> None:
        """Wait until both answer, up to a limit of wall time [s].

        Whatever was started before counts as lost: it is cancelled, since an action server that has
        no engine would start it as soon as there is one.

        Raises:
            LostError: if one of them does not in time.
            LeavingError: if this process is to end.
        """
        if self._goal is not None and not self._goal.wait(0.0):
            self._goal.cancel()
        end_s = time.monotonic() + limit_s
        self._loop.run_until(
            lambda: self._is_fresh and not self.trouble and self._server.is_there, limit_s
        )
        if self.trouble:
            raise LostError(self.trouble)
        self._server.wait(max(0.0, end_s - time.monotonic()))
        if not self._is_fresh:
            raise LostError("the engine does not answer; see its log")

    def start(self, behavior: str) -> None:
        """Have a behavior run."""
        self._path = []
        goal = BehaviorExecutionGoal(behavior_name=behavior)
        self._goal = self._server.send(goal, on_end=lambda: self._loop.post(lambda: None))

    def cancel(self, *, own_only: bool = False) -> None:
        """Have every behavior stopped, from all clients, or only the one started last here."""
        if own_only:
            if self._goal is not None:
                self._goal.cancel()
            return
        self._server.cancel_all()
        self._preempt.publish(Empty())

    def path(self) -> tuple[str, ...]:
        """Return the paths of the states that the behavior started last has entered."""
        return tuple(self._path)

    @property
    def _is_fresh(self) -> bool:
        return self._silent_s is not None and self._silent_s <= _FRESH_S

    def _count_silence(self) -> None:
        if self._silent_s is not None:
            self._silent_s += 1

    def _on_sign(self) -> None:
        self._silent_s = 0

    def _on_status(self, status: BEStatus) -> None:
        self._on_sign()
        self._code = status.code
        self._loop.post(lambda: None)

    def _on_entered(self, entered: String) -> None:
        self.state_path = entered.data
        if entered.data:
            self._path.append(entered.data)


INSPECTION_ACTION = "remodel_abilities/checkconnection"

# [s] ROS time that an inspection gets, and wall time after which its server counts as lost.
_INSPECTION_S = 30.0
_INSPECTION_LIMIT_S = 120.0

# remodel_msgs/ErrorCode.INTERNAL, of an answer that there is not.
_INTERNAL = 5


class Inspection:
    """Inspects terminals."""

    def __init__(self, loop: RosEventLoop) -> None:
        """Connect when the ability is there."""
        self._loop = loop
        self._server = ActionServer(
            INSPECTION_ACTION, CheckConnectionAction, "the cell (remodel_sim cell)"
        )

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
            timeout=_INSPECTION_S,
        )
        sent = self._loop.background(lambda: self._server.ended(goal, _INSPECTION_LIMIT_S))
        result = sent.result
        if result is None or not result.success:
            code = result.error_code if result else _INTERNAL
            text = result.error_message if result else sent.ending
            raise UnseenError(code or _INTERNAL, text, goal.id)
        return bool(result.connected)
