"""What ability states reach the world by: ROS, or what stands for it in the same process.

A state takes the line that is in force when it is made. `by_line` puts another one in force, so
that the very same behaviors run where there is no ROS master, such as in rehearsals.

By the line, a state asks before each operation whether it may begin, and has its record kept before
the next one. A supervisor that can be paused, and that survives its own death, decides about each
operation and needs every finished one in its database before anything else moves. It announces
itself by the parameter `remodel/recorder`: the name of its service of type remodel_msgs/KeepRecord.
Its service of type remodel_msgs/BeginOperation is `begin_operation` in the same namespace. Without
the parameter no operation waits for a supervisor.

A separate thread sends the requests, over one connection to each service, and retries each until
the answer is final; the state only polls. While one state is held, the record of another is kept.
But no operation may begin before the record of a state that was left is kept: it may report that
a person is needed before anything moves again.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Protocol

import rospy
from genpy import Message
from geometry_msgs.msg import PoseStamped
from remodel_msgs.msg import AbilityRecord
from remodel_msgs.srv import (
    BeginOperation,
    BeginOperationRequest,
    BeginOperationResponse,
    KeepRecord,
    KeepRecordRequest,
)

from flexbe_core import Logger
from flexbe_core.proxy import ProxyActionClient, ProxyPublisher

RECORD_TOPIC = "remodel/ability_records"
RECORDER_PARAMETER = "remodel/recorder"

# [s] Wall time between two attempts of a request.
_RETRY_S = 0.25

# [s] Wall time between two warnings that nothing moves.
WARN_EVERY_S = 30.0


def recorder() -> str:
    """Ask the master for the recorder's service; empty if records need not be kept.

    It takes a millisecond: rospy's cache does not remember that a parameter is not set.
    """
    return str(rospy.get_param(RECORDER_PARAMETER, ""))


def owned_id(owner: int, goal_id: str) -> str:
    """Return a goal's id with the token of the supervisor that owns the cell, if there is one."""
    return f"{owner}:{goal_id}" if owner else goal_id


class Request:
    """A request to a supervisor, repeated until the answer is final.

    Attributes:
        recorder: name of the supervisor's KeepRecord service; empty once the parameter is gone.
        trouble: why there is no final answer yet; empty before the first attempt.
        is_final: whether the answer is final, or no longer needed.
    """

    def __init__(self, recorder: str) -> None:
        """Begin to wait."""
        self.recorder = recorder
        self.trouble = ""
        self.is_final = False
        self.due_s = 0.0
        self.is_withdrawn = False
        self._warned_s = time.monotonic()

    @property
    def warning(self) -> str:
        """What delays the request and what to do about it, each WARN_EVERY_S; empty between."""
        if time.monotonic() - self._warned_s < WARN_EVERY_S:
            return ""
        self._warned_s = time.monotonic()
        return (
            f"nothing moves: {self.recorder or RECORDER_PARAMETER} has not accepted the request "
            f"for {WARN_EVERY_S:g} s or longer: {self.trouble or 'no answer'}. Start the "
            "supervisor; or, to run behaviors unsupervised, "
            f"`rosparam delete {rospy.resolve_name(RECORDER_PARAMETER)}`"
        )


class Keeping(Request):
    """A record that is to be kept.

    Attributes:
        record: what is to be kept.
    """

    def __init__(self, record: AbilityRecord, recorder: str) -> None:
        """Begin to wait."""
        super().__init__(recorder)
        self.record = record


class Permit(Request):
    """A goal that may not be sent before the supervisor grants it.

    Attributes:
        operation: what is to begin.
        is_held: whether the last answer was that the run is paused.
        is_granted: whether the goal may be sent, by the answer of a supervisor.
        is_refused: whether the goal must not be sent.
        owner: token of the supervisor that granted it; 0 for none.
        message: the supervisor's reason.
        unsent: see RecordKeeper.give_back.
    """

    def __init__(self, operation: BeginOperationRequest, recorder: str) -> None:
        """Begin to wait."""
        super().__init__(recorder)
        self.operation = operation
        self.is_held = False
        self.is_refused = False
        self.is_granted = False
        self.owner = 0
        self.message = ""
        self.unsent: AbilityRecord | None = None

    @property
    def warning(self) -> str:
        """As of any request, but empty while the run is paused."""
        return "" if self.is_held else super().warning

    def take(self, answer: BeginOperationResponse) -> bool:
        """Take the supervisor's answer; return whether it is final."""
        self.is_held = answer.answer == BeginOperationResponse.HELD
        self.is_granted = answer.answer == BeginOperationResponse.GRANTED
        self.is_refused = not self.is_held and not self.is_granted
        self.owner, self.message = answer.owner, answer.message
        # The supervisor is there: it alone ends the pause, even if the parameter is lost meanwhile.
        self.trouble = ""
        return not self.is_held


class _Connection:
    """A lasting connection to one service of a supervisor."""

    def __init__(self, service_class: type) -> None:
        """Begin without a connection."""
        self._service_class = service_class
        self._proxy: rospy.ServiceProxy | None = None
        self._name = ""

    def call(self, name: str, request: Any) -> Any:  # noqa: ANN401 - of the service class
        """Return the answer; after an error the next call connects again."""
        if self._name != name:
            self._close()
        if self._proxy is None:
            self._proxy = rospy.ServiceProxy(name, self._service_class, persistent=True)
            self._name = name
        try:
            return self._proxy.call(request)
        except Exception:
            self._close()
            raise

    def _close(self) -> None:
        if self._proxy is not None:
            self._proxy.close()
            self._proxy = None


class RecordKeeper:
    """The thread that sends the requests."""

    def __init__(self) -> None:
        """Start the thread; it ends with the process."""
        self._keep, self._begin = _Connection(KeepRecord), _Connection(BeginOperation)
        self._queue: queue.SimpleQueue[Request] = queue.SimpleQueue()
        threading.Thread(target=self._work, name="record keeper", daemon=True).start()

    def ask(self, operation: BeginOperationRequest, recorder: str, trouble: str = "") -> Permit:
        """Begin to ask whether a goal may be sent; return at once.

        Args:
            operation: what is to begin.
            recorder: as Request has it.
            trouble: why the recorder is not known yet; it is then read again for each attempt.
        """
        permit = Permit(operation, recorder)
        permit.trouble = trouble
        self._queue.put(permit)
        return permit

    def keep(self, record: AbilityRecord, recorder: str) -> Keeping:
        """Begin to have a record kept; return at once."""
        keeping = Keeping(record, recorder)
        self._queue.put(keeping)
        return keeping

    def withdraw(self, request: Request) -> None:
        """Wait no longer; a record that is not kept is sent until it is."""
        request.is_withdrawn = True
        self._queue.put(request)

    def give_back(self, permit: Permit, unsent: AbilityRecord) -> None:
        """Do not send the goal; if it was granted, have the record kept that it was not sent.

        Otherwise the supervisor would count the operation as moving forever.
        """
        permit.unsent = unsent
        self.withdraw(permit)

    def _work(self) -> None:
        waiting: list[Request] = []
        while True:
            arrived = self._next(waiting)
            if arrived is not None:
                waiting = [request for request in waiting if request is not arrived]
                waiting += _to_do(arrived)
            waiting.sort(key=lambda request: isinstance(request, Permit))
            now, left = time.monotonic(), waiting
            waiting = [r for r in left if r.due_s > now or not self._is_done(r, left)]

    def _next(self, waiting: list[Request]) -> Request | None:
        """Return a request that arrived; None when the next attempt is due."""
        due_s = min((request.due_s for request in waiting), default=None)
        limit_s = None if due_s is None else max(0.0, due_s - time.monotonic())
        try:
            return self._queue.get(timeout=limit_s)
        except queue.Empty:
            return None

    def _is_done(self, request: Request, waiting: list[Request]) -> bool:
        """Attempt a request, if its turn is next; return whether its answer is final."""
        if isinstance(request, Permit) and any(_is_of_left_state(other) for other in waiting):
            request.trouble = "the record of a state that was left is not kept yet"
        elif not request.is_final:
            self._attempt(request)
        request.due_s = time.monotonic() + _RETRY_S
        return request.is_final

    def _attempt(self, request: Request) -> None:
        try:
            if request.trouble:  # the recorder may be another one by now, or none
                request.recorder = recorder()
            request.is_final = not request.recorder or self._answered(request)
        except Exception as error:  # noqa: BLE001 - rospy promises no type; the thread must continue
            request.trouble = str(error) or type(error).__name__
            if isinstance(request, Permit):
                request.is_held = False

    def _answered(self, request: Request) -> bool:
        """Return whether the supervisor's answer to a request is final."""
        if isinstance(request, Permit):
            namespace, slash, _ = request.recorder.rpartition("/")
            name = f"{namespace}{slash}begin_operation"
            return request.take(self._begin.call(name, request.operation))
        response = self._keep.call(request.recorder, KeepRecordRequest(request.record))
        if not response.success:
            request.trouble = response.message or "it gave no reason"
        return bool(response.success)


def _is_of_left_state(request: Request) -> bool:
    """Return whether a request is to keep the record of a state that was left, and is not done."""
    return isinstance(request, Keeping) and request.is_withdrawn and not request.is_final


def _to_do(request: Request) -> list[Request]:
    """Return what is to be attempted for a request that arrived."""
    request.due_s = 0.0
    if not (isinstance(request, Permit) and request.is_withdrawn):
        return [request]
    if not request.is_granted or request.unsent is None:
        return []
    request.unsent.goal_id = owned_id(request.owner, request.unsent.goal_id)
    keeping = Keeping(request.unsent, request.recorder)
    keeping.is_withdrawn = True
    return [keeping]


@cache
def keeper() -> RecordKeeper:
    """Return the process's keeper: the states of all behaviors share its connections."""
    return RecordKeeper()


# What ability states reach the world by


class Client(Protocol):
    """An action client, as FlexBE's proxy has it; the topic is that of the server."""

    def send_goal(self, topic: str, goal: Message) -> None:
        """Send a goal; raises if there is no server."""

    def is_available(self, topic: str) -> bool:
        """Return whether the server is there."""

    def has_result(self, topic: str) -> bool:
        """Return whether the server has answered."""

    def get_result(self, topic: str) -> Message | None:
        """Return the answer; None if there is none."""

    def get_state(self, topic: str) -> int:
        """Return the status of the goal, of actionlib_msgs/GoalStatus."""

    def get_goal_status_text(self, topic: str) -> str:
        """Return what the server says about the goal."""

    def cancel(self, topic: str) -> None:
        """Ask the server to end the goal."""


class Keeper(Protocol):
    """Asks a supervisor, and has it keep records; see RecordKeeper."""

    def ask(self, operation: BeginOperationRequest, recorder: str, trouble: str = "") -> Permit:
        """Begin to ask whether a goal may be sent."""

    def keep(self, record: AbilityRecord, recorder: str) -> Keeping:
        """Begin to have a record kept."""

    def withdraw(self, request: Request) -> None:
        """Wait no longer."""

    def give_back(self, permit: Permit, unsent: AbilityRecord) -> None:
        """Do not send the goal."""


class Line(Protocol):
    """The world of ability states."""

    def client(self, topic: str, action_type: type[Message]) -> Client:
        """Connect to the server of an ability."""

    def recorder(self) -> str:
        """Return the name of the supervisor's service for records; empty without a supervisor."""

    def keeper(self) -> Keeper:
        """Return what asks that supervisor."""

    def publish(self, record: AbilityRecord) -> None:
        """Publish the record of an ability that has ended."""

    def warn(self, text: str) -> None:
        """Warn operators."""


class RosLine:
    """The line over ROS."""

    def client(self, topic: str, action_type: type[Message]) -> Client:
        """Connect to an action server; stock FlexBE's proxies warn if it is not there."""
        ProxyPublisher({RECORD_TOPIC: AbilityRecord})
        client: Client = ProxyActionClient({topic: action_type})
        return client

    def recorder(self) -> str:
        """Ask the ROS master."""
        return recorder()

    def keeper(self) -> Keeper:
        """Return the process's."""
        return keeper()

    def publish(self, record: AbilityRecord) -> None:
        """Publish it."""
        ProxyPublisher().publish(RECORD_TOPIC, record)

    def warn(self, text: str) -> None:
        """Log it, at the console too."""
        Logger.logwarn(text)


_in_force: list[Line] = [RosLine()]


def line() -> Line:
    """Return the line that is in force."""
    return _in_force[-1]


@contextmanager
def by_line(other: Line) -> Iterator[None]:
    """Put another line in force for the states that are made meanwhile."""
    _in_force.append(other)
    try:
        yield
    finally:
        _in_force.remove(other)


# Messages as the "name=value" texts of an ability record


def described(message: Message, left_out: Collection[str]) -> list[str]:
    """Return the numbers, truth values, texts and poses of a message as "name=value"."""
    fields = {name: getattr(message, name) for name in message.__slots__ if name not in left_out}
    texts = {name: _text(value) for name, value in fields.items()}
    return [f"{name}={text}" for name, text in texts.items() if text is not None]


def _text(value: object) -> str | None:
    """Return a value as text; None if it is neither plain nor a pose, or several."""
    if isinstance(value, bool | int | float | str):
        return str(value)
    if isinstance(value, PoseStamped):
        position, turn = value.pose.position, value.pose.orientation
        numbers = (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w)
        return " ".join(
            [value.header.frame_id or "-", *(f"{round(n, 6) + 0.0:g}" for n in numbers)]
        )
    if isinstance(value, list) and value and all(isinstance(item, PoseStamped) for item in value):
        return "; ".join(str(_text(item)) for item in value)
    return None
