"""The task supervisor: runs one task's behavior and gathers what its abilities did and saw."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import rospy
from flexbe_msgs.msg import BehaviorExecutionAction, BehaviorExecutionGoal
from remodel_msgs.msg import AbilityRecord
from sensor_msgs.msg import Image
from std_msgs.msg import Empty

from remodel_planner.core.run import Operation
from remodel_planner.errors import CellError
from remodel_planner.ros.action_server import ActionServer, Goal

ACTION = "flexbe/execute_behavior"
RECORDS = "remodel/ability_records"
HEARTBEAT = "flexbe/heartbeat"
CAMERAS = ("overhead", "wrist")

# [s] wall time without a heartbeat of the engine (1 Hz), or without progress of the cell's clock,
# after which a task is given up.
SILENCE_LIMIT_S = 15.0


@dataclass(frozen=True)
class Sight:
    """An annotated picture that an ability made."""

    camera: str
    stamp_s: float
    image: Image


@dataclass(frozen=True)
class TaskRun:
    """How one task's behavior went; times are ROS time."""

    outcome: str
    started_s: float
    ended_s: float
    operations: tuple[Operation, ...]
    sights: tuple[Sight, ...]


class TaskSupervisor:
    """Runs behaviors, one at a time."""

    def __init__(self) -> None:
        """Connect to the engine's action server and to what abilities publish.

        Raises:
            CellError: if the action server is not there in time.
        """
        self._server = ActionServer(ACTION, BehaviorExecutionAction, "be_action_server")
        self._operations: list[Operation] = []
        self._sights: list[Sight] = []
        self._alive = threading.Event()
        rospy.Subscriber(RECORDS, AbilityRecord, self._on_record)
        rospy.Subscriber(HEARTBEAT, Empty, lambda _: self._alive.set())
        for camera in CAMERAS:
            topic = f"cell/{camera}/detections"
            rospy.Subscriber(topic, Image, self._on_image, callback_args=camera)

    def run(self, behavior: str) -> TaskRun:
        """Run a behavior to its end.

        Raises:
            CellError: if the engine or the cell's clock falls silent; the goal is cancelled.
        """
        self._operations, self._sights = [], []
        started_s = rospy.get_time()
        goal = self._server.send(BehaviorExecutionGoal(behavior_name=behavior))
        while not goal.wait(SILENCE_LIMIT_S):
            if not self._alive.is_set() or rospy.is_shutdown():
                goal.cancel()
                raise CellError(
                    f"the engine has been silent for {SILENCE_LIMIT_S:.0f} s while {behavior!r} "
                    "ran; look at its log"
                )
            self._alive.clear()
        return TaskRun(
            _outcome(goal),
            started_s,
            rospy.get_time(),
            tuple(self._operations),
            tuple(self._sights),
        )

    def _on_record(self, record: AbilityRecord) -> None:
        self._operations.append(
            Operation(
                record.state_path,
                record.ability,
                record.outcome,
                record.error_code,
                record.error_message or record.message,
                record.stamp.to_sec(),
                record.elapsed_time,
            )
        )

    def _on_image(self, image: Image, camera: str) -> None:
        self._sights.append(Sight(camera, image.header.stamp.to_sec(), image))


def _outcome(goal: Goal) -> str:
    return goal.result.outcome if goal.succeeded else goal.ending
