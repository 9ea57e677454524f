"""The mirror as a ROS node, at stock FlexBE's import path: publishes which state is active.

`flexbe/behavior_update` is latched: a late subscriber receives the active state at once. ROS
callbacks put messages into a queue, and one thread handles them, so that their order is kept.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable

import rospy
from flexbe_msgs.msg import BehaviorSync, BEStatus, ContainerStructure
from genpy import Message
from std_msgs.msg import Empty, Int32, String, UInt8

from flexbe_core.ros import topics
from flexbe_mirror.mirror import (
    Action,
    AskForStructure,
    AskWhere,
    Mirror,
    Part,
    Show,
    StructureError,
    Tree,
)

# [s] Wall time between two checks of what is late.
_CHECK_EVERY_S = 0.1


class FlexbeMirror:
    """The mirror of the engine of one namespace."""

    def __init__(self) -> None:
        self._mirror = Mirror()
        self._arrived: queue.SimpleQueue[Callable[[], list[Action]]] = queue.SimpleQueue()
        self._update = rospy.Publisher(topics.BEHAVIOR_UPDATE, String, queue_size=100, latch=True)
        self._request = rospy.Publisher(topics.REQUEST_STRUCTURE, Int32, queue_size=10)
        self._ask_where = rospy.Publisher(topics.SYNC, Empty, queue_size=10)
        for topic, message_type, handle in (
            (topics.MIRROR_STRUCTURE, ContainerStructure, self._on_structure),
            (topics.MIRROR_OUTCOME, UInt8, self._on_outcome),
            (topics.MIRROR_SYNC, BehaviorSync, self._on_sync),
            ("flexbe/status", BEStatus, self._on_status),
            ("flexbe/heartbeat", Empty, lambda m: self._mirror.on_heartbeat(time.monotonic())),
        ):
            rospy.Subscriber(topic, message_type, self._put, handle, tcp_nodelay=True)
        self._names = rospy.Subscriber(
            topics.ACTIVE_STATE, String, self._put, self._on_active_state, tcp_nodelay=True
        )
        threading.Thread(target=self._work, name="mirror", daemon=True).start()

    def _put(self, message: Message, handle: Callable[[Message], list[Action]]) -> None:
        self._arrived.put(lambda: handle(message))

    def _work(self) -> None:
        while not rospy.is_shutdown():
            actions: list[Action] = []
            try:
                actions = self._arrived.get(timeout=_CHECK_EVERY_S)()
            except queue.Empty:
                pass
            except StructureError as error:
                rospy.logwarn("ignored a structure: %s", error)
            for action in [*actions, *self._mirror.on_time(time.monotonic())]:
                self._do(action)

    def _do(self, action: Action) -> None:
        if isinstance(action, Show):
            self._update.publish(action.path)
        elif isinstance(action, AskForStructure):
            self._request.publish(action.behavior_id)
        elif isinstance(action, AskWhere):
            self._ask_where.publish()

    def _on_status(self, message: BEStatus) -> list[Action]:
        args = tuple(message.args)
        return self._mirror.on_status(message.code, message.behavior_id, args, time.monotonic())

    def _on_structure(self, message: ContainerStructure) -> list[Action]:
        tree = Tree(
            Part(
                part.path,
                tuple(part.children),
                tuple(zip(part.outcomes, part.transitions, strict=False)),
            )
            for part in message.containers
        )
        return self._mirror.on_structure(message.behavior_id, tree)

    def _on_active_state(self, message: String) -> list[Action]:
        return self._mirror.on_active_state(message.data)

    def _on_outcome(self, message: UInt8) -> list[Action]:
        if self._is_named():
            return []
        return self._mirror.on_outcome(message.data)

    def _on_sync(self, message: BehaviorSync) -> list[Action]:
        if self._is_named():
            return []
        return self._mirror.on_sync(message.behavior_id, message.current_state_checksum)

    def _is_named(self) -> bool:
        """Return whether the engine names its active state itself, in the order of the run."""
        return self._names.get_num_connections() > 0


__all__ = ["FlexbeMirror"]
