"""The mirror: follow one behavior after the other in the tree of its states and containers.

    idle --STARTED--> waiting for the structure --structure--> following
      ^                     |  (asks for it after ASK_AFTER_S)     |
      +---------------------+-------- any end, silence -----------+

An engine of this workspace publishes its active state, in the order of the run: on_active_state.
With any other engine, on_outcome goes from state to state through the structure, and on_sync
jumps. Outcomes and syncs arrive on separate topics, and may overtake each other.

While an engine is silent, no state is shown; when its heartbeat resumes, the mirror follows it
again. Each method of Mirror returns what to do: Show, AskForStructure, AskWhere. A mirror that
joins late, or gets the structure late, does not know the active state and asks for it.

FlexbeMirror is the node's part, at stock FlexBE's import path. `flexbe/behavior_update` is latched:
a late subscriber receives the active state at once. ROS callbacks put messages into a queue, and
one thread handles them, so that their order is kept.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import rospy
from flexbe_msgs.msg import BehaviorSync, BEStatus, Container, ContainerStructure
from genpy import Message
from std_msgs.msg import Empty, Int32, String, UInt8

from flexbe_core.engine.supervision import StatusCode, checksum
from flexbe_core.ros import topics


class StructureError(ValueError):
    """A structure message that does not describe a whole behavior."""


class Tree:
    """The parts of one behavior.

    Attributes:
        parts: path -> container or state.
    """

    def __init__(self, parts: Iterable[Container]) -> None:
        """Put the parts together; their order does not matter.

        Raises:
            StructureError: if there is no root, or a child is missing.
        """
        self.parts = {part.path: part for part in parts}
        if "" not in self.parts:
            raise StructureError("the structure has no root, a container with an empty path")
        missing = [
            f"{part.path}/{label}"
            for part in self.parts.values()
            for label in part.children
            if f"{part.path}/{label}" not in self.parts
        ]
        if missing:
            raise StructureError(f"the structure lacks {', '.join(missing)}")

    def first_state(self, path: str = "") -> str:
        """Return the state that is active first in a container; a state stands for itself."""
        while self.parts[path].children:
            path = f"{path}/{self.parts[path].children[0]}"
        return path

    def state_with(self, path_checksum: int) -> str | None:
        """Return the part whose path has this checksum; None if there is none."""
        return next((path for path in self.parts if checksum(path) == path_checksum), None)

    def follow(self, path: str, outcome_index: int) -> str | None:
        """Return the state that is active after a state took an outcome; None after the last.

        Raises:
            LookupError: if there is no such state, or it has no such outcome.
        """
        part = self.parts[path]
        if not 0 <= outcome_index < len(part.transitions):
            raise IndexError(f"{path} has no outcome {outcome_index}")
        target = part.transitions[outcome_index]
        while path:
            container = path.rpartition("/")[0]
            if target in self.parts[container].children:
                return self.first_state(f"{container}/{target}")
            path, part = container, self.parts[container]
            target = dict(zip(part.outcomes, part.transitions, strict=False)).get(target, target)
        return None


# [s] The structure arrives by itself with a behavior that an operator starts; otherwise the mirror
# asks for it after this long, and again until it arrives.
ASK_AFTER_S = 0.2
ASK_AGAIN_S = 1.0

# [s] The engine beats once per second.
SILENCE_S = 5.0


@dataclass(frozen=True)
class Show:
    """Publish that this state is active; empty if none is."""

    path: str


@dataclass(frozen=True)
class AskForStructure:
    """Ask the engine for the structure of the behavior with this id."""

    behavior_id: int


@dataclass(frozen=True)
class AskWhere:
    """Ask the engine which state is active."""


Action = Show | AskForStructure | AskWhere

_ENDS = {StatusCode.FINISHED, StatusCode.FAILED, StatusCode.SWITCHING, StatusCode.READY}


class Mirror:
    """The active state of the running behavior.

    Attributes:
        path: of the active state; empty if none is, or it is not known.
    """

    def __init__(self) -> None:
        self.path = ""
        self._is_new = True
        self._behavior_id: int | None = None
        self._tree: Tree | None = None
        self._buffered: dict[int, Tree] = {}
        self._ask_at = 0.0
        self._heard_at = 0.0
        self._lost: int | None = None
        self._named = ""
        self._is_first = False

    def on_heartbeat(self, now: float) -> list[Action]:
        """Take a sign of life of the engine; `now` [s] is wall time."""
        self._heard_at = now
        lost, self._lost = self._lost, None
        return [] if lost is None else self._begin(lost, None, now)

    def on_status(
        self, code: int, behavior_id: int, args: tuple[str, ...], now: float
    ) -> list[Action]:
        """Take a status of the engine; `now` [s] is wall time."""
        self._heard_at, self._lost = now, None
        if code == StatusCode.STARTED:
            return self._begin(behavior_id, args[0] if args else None, now)
        if self._behavior_id is None:
            return self._show("") if self._is_new else []
        is_end = code in _ENDS or (code == StatusCode.ERROR and behavior_id == self._behavior_id)
        return self._end() if is_end else []

    def on_structure(self, behavior_id: int, tree: Tree) -> list[Action]:
        """Take the structure of a behavior; it may arrive before the behavior is started."""
        self._buffered = {behavior_id: tree}
        if behavior_id != self._behavior_id or self._tree is not None:
            return []
        self._tree = tree
        return [AskWhere()]

    def on_active_state(self, path: str) -> list[Action]:
        """Take the active state from an engine that publishes it, perhaps before STARTED."""
        self._named = path
        is_known = self._is_first and path == self.path
        # A status reports that no state is active.
        return [] if self._behavior_id is None or not path or is_known else self._show(path)

    def on_outcome(self, index: int) -> list[Action]:
        """Take the outcome of the active state."""
        if self._tree is None or not self.path:
            return []
        try:
            following = self._tree.follow(self.path, index)
        except LookupError:
            return [AskWhere()]
        return [] if following is None else self._show(following)

    def on_sync(self, behavior_id: int, path_checksum: int) -> list[Action]:
        """Take the active state, by the checksum of its path."""
        if self._tree is None or behavior_id != self._behavior_id:
            return []
        path = self._tree.state_with(path_checksum)
        return [] if path is None else self._show(path)

    def on_time(self, now: float) -> list[Action]:
        """Ask for what is missing, once it is late; `now` [s] is wall time."""
        if self._behavior_id is None:
            return []
        if now - self._heard_at > SILENCE_S:
            self._lost = self._behavior_id
            return self._end()
        if self.path or now < self._ask_at:
            return []
        self._ask_at = now + ASK_AGAIN_S
        return [AskForStructure(self._behavior_id) if self._tree is None else AskWhere()]

    def _begin(self, behavior_id: int, resume_at: str | None, now: float) -> list[Action]:
        self._behavior_id = behavior_id
        self._tree, self.path = self._buffered.get(behavior_id), ""
        self._ask_at = now + ASK_AFTER_S
        if self._named:
            return self._show(self._named)
        if self._tree is None:
            return []
        is_there = resume_at in self._tree.parts
        actions = self._show(resume_at if is_there else self._tree.first_state())
        self._is_first = True  # and not to be shown again when the engine names it
        return actions

    def _show(self, path: str | None) -> list[Action]:
        self._is_new = self._is_first = False
        self.path = path or ""
        return [Show(self.path)]

    def _end(self) -> list[Action]:
        # A request for the structure makes the engine supervise the run; each run needs one.
        if self._behavior_id is not None:
            self._buffered.pop(self._behavior_id, None)
        self._behavior_id = self._tree = None
        self._named = ""
        return self._show("")


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
        return self._mirror.on_structure(message.behavior_id, Tree(message.containers))

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
