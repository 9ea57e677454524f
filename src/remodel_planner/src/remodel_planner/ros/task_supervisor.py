"""The task supervisor: runs one task's behavior, watches it, and gathers what was done and seen."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import rospy
from flexbe_msgs.msg import BehaviorExecutionAction, BehaviorExecutionGoal, BEStatus
from remodel_msgs.msg import AbilityRecord
from remodel_msgs.srv import KeepRecord, KeepRecordResponse
from sensor_msgs.msg import Image
from std_msgs.msg import Bool, Empty, String

from remodel_planner.core.run import Operation
from remodel_planner.errors import LostError
from remodel_planner.ros.ability_feedback import AbilityFeedback
from remodel_planner.ros.action_server import ActionServer, Goal
from remodel_planner.ros.peer import Peer

ACTION = "flexbe/execute_behavior"
RECORDS = "remodel/ability_records"
RECORDER = "remodel/keep_record"
RECORDER_PARAMETER = "remodel/recorder"
CAMERAS = ("overhead", "wrist")

# [s] wall time without a heartbeat of the engine (1 Hz) after which it counts as lost.
SILENCE_LIMIT_S = 15.0

# What the engine says while a behavior runs.
_RUNNING = (BEStatus.STARTED, BEStatus.SWITCHING, BEStatus.LOCKED, BEStatus.WAITING)

# [s] wall time between two looks at a behavior that runs.
_LOOK_S = 0.02

# [s] wall time that a behavior gets to stop when it is told to.
_STOP_LIMIT_S = 20.0

# [s] wall time that the engine's topic may lag behind the end of a behavior.
_LAG_LIMIT_S = 2.0

Keep = Callable[[Operation], None]


@dataclass(frozen=True)
class Sight:
    """An annotated picture that an ability made."""

    camera: str
    stamp_s: float
    image: Image


class TaskSupervisor:
    """Runs behaviors, one at a time.

    Attributes:
        abilities: what they do.
        state_path: of the state in which the engine is; empty if it says none.
    """

    def __init__(self) -> None:
        """Offer to keep records, and listen to the engine and to what abilities publish."""
        self._keep: Keep | None = None
        self._settling = False
        self._lock = threading.Lock()
        self._sights: list[Sight] = []
        self._path: list[str] = []
        self._heard_s = 0.0
        self._code = BEStatus.READY
        self.state_path = ""
        self.abilities = AbilityFeedback()
        self._server = ActionServer(ACTION, BehaviorExecutionAction, "be_action_server")
        self._pause = rospy.Publisher("flexbe/command/pause", Bool, queue_size=10)
        self._preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=10)
        self._engine = Peer("the engine", "flexbe/heartbeat", Empty, self._on_heartbeat)
        self._runner = Peer("the engine's action server", f"{ACTION}/feedback")
        rospy.Subscriber("flexbe/status", BEStatus, self._on_status)
        rospy.Subscriber("flexbe/behavior_update", String, self._on_entered, tcp_nodelay=True)
        for camera in CAMERAS:
            topic = f"cell/{camera}/detections"
            rospy.Subscriber(topic, Image, self._on_image, callback_args=camera)
        rospy.Service(RECORDER, KeepRecord, self._on_record)

    @contextlib.contextmanager
    def recording(self, *, settling: bool) -> Iterator[None]:
        """Have all behaviors wait for this supervisor to keep what they did, meanwhile.

        When this process is killed they go on waiting: for the next one, which stops them.

        Args:
            settling: a behavior of an earlier supervisor may run; nothing of it is kept any more.
        """
        self._settling = settling
        rospy.set_param(RECORDER_PARAMETER, rospy.resolve_name(RECORDER))
        try:
            yield
        finally:
            with contextlib.suppress(KeyError, OSError):
                rospy.delete_param(RECORDER_PARAMETER)

    def wait(self, limit_s: float) -> None:
        """Wait for engine and action server, up to a limit of wall time [s].

        Raises:
            LostError: if one of them is not there in time.
        """
        end = time.monotonic() + limit_s
        for peer in (self._engine, self._runner, self._server):
            peer.wait(max(0.0, end - time.monotonic()))

    def run(self, behavior: str, keep: Keep, is_to_stop: Callable[[], bool]) -> str:
        """Run a behavior to its end, and return its outcome.

        Args:
            behavior: its name.
            keep: keeps each operation when it has ended; the behavior goes on when it has.
            is_to_stop: asked again and again whether the behavior is to be stopped.

        Raises:
            LostError: if engine or action server are lost; the behavior is in doubt.
        """
        self._sights, self._path = [], []
        worked: Counter[str] = Counter()

        def note(operation: Operation) -> None:
            keep(operation)
            worked[operation.state_path] += 1

        self._keep = note
        self._heard_s = time.monotonic()
        try:
            goal = self._server.send(BehaviorExecutionGoal(behavior_name=behavior))
            outcome = self._watch(goal, is_to_stop)
            self._await_path(worked)
            return outcome
        finally:
            with self._lock:
                self._keep = None

    def stop_all(self) -> None:
        """Stop what runs on the engine, and return when nothing does.

        Raises:
            LostError: if something still runs after a while, or the engine is lost.
        """
        if self._code in _RUNNING:
            self._server.cancel_all()
            self._preempt.publish(Empty())
        end = time.monotonic() + _STOP_LIMIT_S
        while self._code in _RUNNING or self.abilities.running:
            for peer in (self._engine, self._runner):
                peer.require()
            if time.monotonic() > end:
                still = "the behavior" if self._code in _RUNNING else "an ability"
                raise LostError(
                    f"{still} still runs {_STOP_LIMIT_S:.0f} s after it was told to stop; stop the "
                    "cell by hand"
                )
            time.sleep(_LOOK_S)
        self._settling = False

    def pause(self, paused: bool) -> None:
        """Have the engine hold before its next state, or go on."""
        self._pause.publish(Bool(paused))

    def path(self) -> tuple[str, ...]:
        """Return the paths of the states that the behavior has entered that was run last."""
        return tuple(self._path)

    def sights(self) -> tuple[Sight, ...]:
        """Return the pictures that abilities made in the behavior that was run last."""
        return tuple(self._sights)

    def _watch(self, goal: Goal, is_to_stop: Callable[[], bool]) -> str:
        stopping_until = 0.0
        while not goal.wait(_LOOK_S):
            self._require_alive()
            if stopping_until and time.monotonic() > stopping_until:
                raise LostError(f"the behavior does not stop within {_STOP_LIMIT_S:.0f} s")
            if not stopping_until and is_to_stop():
                goal.cancel()
                stopping_until = time.monotonic() + _STOP_LIMIT_S
        if goal.lost:
            raise LostError("the engine's action server does not know the behavior any more")
        return goal.result.outcome if goal.succeeded else goal.ending

    def _await_path(self, worked: Counter[str]) -> None:
        """Wait until the engine has told, on another topic, of the states that have worked."""
        end = time.monotonic() + _LAG_LIMIT_S
        while worked - Counter(self._path) and time.monotonic() < end:
            time.sleep(_LOOK_S)

    def _require_alive(self) -> None:
        for peer in (self._engine, self._runner):
            peer.require()
        silent_s = time.monotonic() - self._heard_s
        if silent_s > SILENCE_LIMIT_S:
            raise LostError(f"the engine has been silent for {silent_s:.0f} s; look at its log")
        if rospy.is_shutdown():
            raise LostError("this node is told to shut down")

    def _on_heartbeat(self, _: Empty) -> None:
        self._heard_s = time.monotonic()

    def _on_status(self, status: BEStatus) -> None:
        self._code = status.code

    def _on_entered(self, entered: String) -> None:
        self.state_path = entered.data
        if entered.data:
            self._path.append(entered.data)

    def _on_record(self, request: KeepRecord) -> KeepRecordResponse:
        with self._lock:
            if self._settling:
                return KeepRecordResponse(False, "this behavior is about to be stopped")
            if self._keep is None:
                return KeepRecordResponse(True, "of no task; it is not kept")
            self._keep(operation_of(request.record))
        return KeepRecordResponse(True, "")

    def _on_image(self, image: Image, camera: str) -> None:
        self._sights.append(Sight(camera, image.header.stamp.to_sec(), image))


def operation_of(record: AbilityRecord) -> Operation:
    """Return a record as the planner keeps it."""
    return Operation(
        record.state_path,
        record.ability,
        record.outcome,
        record.error_code,
        record.error_message or record.message,
        record.stamp.to_sec(),
        record.elapsed_time,
        record.goal_id,
        _pairs(record.parameters),
        _pairs(record.measurements),
    )


def _pairs(lines: list[str]) -> tuple[tuple[str, str], ...]:
    return tuple((name, value) for name, _, value in (line.partition("=") for line in lines))
