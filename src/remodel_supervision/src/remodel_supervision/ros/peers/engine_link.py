"""The behavior engine and its action server, as the task supervisor uses them."""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import BehaviorExecutionAction, BehaviorExecutionGoal, BEStatus
from rospy import AnyMsg
from std_msgs.msg import Empty, String

from remodel_production.errors import LostError
from remodel_supervision.ros.action_server import ActionServer, Goal
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind


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


ACTION = "flexbe/execute_behavior"

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
        self._server = ActionServer(ACTION, BehaviorExecutionAction, "be_action_server")
        self._preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=10)
        self._engine = Peer("the engine", "flexbe/heartbeat", Empty, lambda _: self._on_sign())
        self._runner = Peer("the engine's action server", f"{ACTION}/feedback")
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
