"""Ability servers and their clients in one process: what actionlib does between two."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from genpy import Message
from remodel_msgs.msg import AbilityRecord, CheckConnectionGoal
from remodel_msgs.srv import BeginOperationRequest, BeginOperationResponse

from remodel_rehearsal.ros.cell import CellLoop
from remodel_states.core.codes import Code
from remodel_states.core.contract import owner_of
from remodel_states.line import Keeping, Permit, Request
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.gate import Permit as Answer
from remodel_supervision.core.runs.state import PERSON_FIRST
from remodel_supervision.ros.server.run_services import operation_of
from remodel_supervision.supervisors.ports import Doing, UnseenError, server_of
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor

_ENDED = frozenset(
    {
        GoalStatus.SUCCEEDED,
        GoalStatus.ABORTED,
        GoalStatus.PREEMPTED,
        GoalStatus.REJECTED,
        GoalStatus.RECALLED,
    }
)

# [s] cell time that an inspection gets.
INSPECTION_S = 30.0
INSPECTION = "remodel_abilities/checkconnection"

# What states ask, and who answers, has this name; there is one supervisor.
RECORDER = "remodel/keep_record"


class GoalHandle:
    """One goal, for its server and its client: actionlib's ServerGoalHandle, and what came of it.

    Attributes:
        status: of actionlib_msgs/GoalStatus.
        text: what the server says about it.
        result: its answer; None before.
    """

    def __init__(self, goal: Message, number: int, on_end: Callable[[GoalHandle], None]) -> None:
        """Send a goal."""
        self.status, self.text = GoalStatus.PENDING, ""
        self.result: Message | None = None
        self._goal, self._on_end = goal, on_end
        self._id = GoalID(rospy.Time.now(), f"goal {number}")

    @property
    def is_ended(self) -> bool:
        """Whether the server has answered."""
        return self.status in _ENDED

    def get_goal(self) -> Message:
        """Return the goal."""
        return self._goal

    def get_goal_id(self) -> GoalID:
        """Return its id, and when it was sent."""
        return self._id

    def get_goal_status(self) -> GoalStatus:
        """Return its status."""
        return GoalStatus(self._id, self.status, self.text)

    def set_accepted(self, text: str = "") -> None:
        """Begin it."""
        self.status, self.text = GoalStatus.ACTIVE, text

    def set_rejected(self, result: Message, text: str = "") -> None:
        """Refuse it."""
        self._end(GoalStatus.REJECTED, result, text)

    def set_succeeded(self, result: Message, text: str = "") -> None:
        """End it as done."""
        self._end(GoalStatus.SUCCEEDED, result, text)

    def set_aborted(self, result: Message, text: str = "") -> None:
        """End it as not done."""
        self._end(GoalStatus.ABORTED, result, text)

    def set_canceled(self, result: Message, text: str = "") -> None:
        """End it as cancelled."""
        self._end(GoalStatus.PREEMPTED, result, text)

    def publish_feedback(self, feedback: Message) -> None:
        """No client reads it."""

    def _end(self, status: int, result: Message, text: str) -> None:
        self.status, self.result, self.text = status, result, text
        self._on_end(self)


OnHandle = Callable[[GoalHandle], None]


@dataclass
class _Server:
    """An action server: what takes its goals and cancels, and those that have not ended."""

    ability: str
    on_goal: OnHandle
    on_cancel: OnHandle
    open: list[GoalHandle] = field(default_factory=list)


class Exchange:
    """All action servers of the process: their host, and the supervisor's port `Abilities`.

    Attributes:
        on_end: called when any goal has ended.
        latest: what an ability does, for people; None: no person reads it.
    """

    latest: Doing | None = None

    def __init__(self) -> None:
        """Begin without servers."""
        self.on_end: Callable[[], None] = lambda: None
        self._servers: dict[str, _Server] = {}
        self._numbers = itertools.count(1)
        self._stops: list[Operation] = []

    # --- host of ability servers

    def limits(self) -> Mapping[str, float]:
        """Return no limits: those of the cell's own are checked by its goals."""
        return {}

    def serve(
        self, topic: str, action_type: type[Message], on_goal: OnHandle, on_cancel: OnHandle
    ) -> object:
        """Serve an action."""
        ability = action_type.__name__.removesuffix("Action")
        server = self._servers[topic] = _Server(ability, on_goal, on_cancel)
        return server

    # --- clients

    def send(self, topic: str, goal: Message) -> GoalHandle:
        """Send a goal.

        Raises:
            ValueError: if the cell has no server for it.
        """
        server = self._servers.get(topic)
        if server is None:
            there_are = ", ".join(self._servers)
            raise ValueError(f"no ability at {topic}; the simulated cell has: {there_are}")
        handle = GoalHandle(goal, next(self._numbers), lambda handle: self._ended(server, handle))
        server.open.append(handle)
        server.on_goal(handle)
        return handle

    def cancel_goal(self, topic: str, handle: GoalHandle) -> None:
        """Ask the server to end a goal."""
        if not handle.is_ended:
            self._servers[topic].on_cancel(handle)

    def serves(self, topic: str) -> bool:
        """Return whether an action is served."""
        return topic in self._servers

    def _ended(self, server: _Server, handle: GoalHandle) -> None:
        server.open = [each for each in server.open if each is not handle]
        result = handle.result
        code = getattr(result, "error_code", Code.NONE)
        if result is not None and code in PERSON_FIRST - {Code.STALE_OWNER}:
            self._stops.append(
                Operation(
                    "",
                    server.ability,
                    "",
                    code,
                    text=result.error_message,
                    ended_s=rospy.get_time(),
                    elapsed_s=result.elapsed_time,
                    goal_id=result.id,
                )
            )
        self.on_end()

    # --- port Abilities

    def cancel(self, owner: int | None = None) -> None:
        """Cancel every goal, or only those that an owner of the cell granted."""
        for server in self._servers.values():
            for handle in tuple(server.open):
                if owner is None or owner_of(handle.get_goal().id) == owner:
                    server.on_cancel(handle)

    def are_quiet(self, since_s: float, owner: int | None = None) -> bool:
        """Return whether no goal is open."""
        return not self.restless(since_s, owner)

    def restless(self, since_s: float, owner: int | None = None) -> tuple[str, ...]:
        """Return the servers that have an open goal."""
        return tuple(
            server_of(server.ability)
            for server in self._servers.values()
            if any(owner is None or owner_of(h.get_goal().id) == owner for h in server.open)
        )

    def answers(self, ability: str, since_s: float) -> bool:
        """Return whether the server of an ability rests."""
        return self.is_connected(ability) and server_of(ability) not in self.restless(since_s)

    def is_connected(self, ability: str) -> bool:
        """Return whether there is a server of an ability."""
        return any(server.ability == ability for server in self._servers.values())

    def take_stops(self) -> tuple[Operation, ...]:
        """Return, once, the results after which nothing may move before a person has answered."""
        stops, self._stops = self._stops, []
        return tuple(stops)


class Client:
    """The action client of one ability state; see remodel_states.line.Client."""

    def __init__(self, exchange: Exchange) -> None:
        """Begin without a goal."""
        self._exchange = exchange
        self._handle: GoalHandle | None = None

    def send_goal(self, topic: str, goal: Message) -> None:
        """Send a goal."""
        self._handle = self._exchange.send(topic, goal)

    def is_available(self, topic: str) -> bool:
        """Return whether the server is there."""
        return self._exchange.serves(topic)

    def has_result(self, topic: str) -> bool:
        """Return whether the server has answered."""
        return self._handle is not None and self._handle.is_ended

    def get_result(self, topic: str) -> Message | None:
        """Return the answer; None if there is none."""
        return self._handle.result if self._handle else None

    def get_state(self, topic: str) -> int:
        """Return the status of the goal."""
        return self._handle.status if self._handle else GoalStatus.LOST

    def get_goal_status_text(self, topic: str) -> str:
        """Return what the server says about the goal."""
        return self._handle.text if self._handle else ""

    def cancel(self, topic: str) -> None:
        """Ask the server to end the goal."""
        if self._handle is not None:
            self._exchange.cancel_goal(topic, self._handle)


class SupervisedLine:
    """The line of ability states to the abilities and the supervisor; see remodel_states.line.

    Attributes:
        supervisor: that is asked; None while there is none.
        warnings: what the states had to say.
    """

    def __init__(self, exchange: Exchange) -> None:
        """Take the abilities."""
        self.supervisor: UseCaseSupervisor | None = None
        self.warnings: list[str] = []
        self._exchange = exchange
        self._waiting: list[Request] = []

    def client(self, topic: str, action_type: type[Message]) -> Client:
        """Connect to the server of an ability."""
        return Client(self._exchange)

    def recorder(self) -> str:
        """Return a name: there is a supervisor."""
        return RECORDER

    def keeper(self) -> SupervisedLine:
        """Return itself."""
        return self

    def publish(self, record: AbilityRecord) -> None:
        """Only the supervisor reads it, which keeps it."""

    def warn(self, text: str) -> None:
        """Note it."""
        self.warnings.append(text)

    # --- keeper

    def ask(self, operation: BeginOperationRequest, recorder: str, trouble: str = "") -> Permit:
        """Ask the supervisor whether a goal may be sent."""
        permit = Permit(operation, recorder)
        self._attempt(permit)
        return permit

    def keep(self, record: AbilityRecord, recorder: str) -> Keeping:
        """Have the supervisor keep a record."""
        keeping = Keeping(record, recorder)
        self._attempt(keeping)
        return keeping

    def withdraw(self, request: Request) -> None:
        """Wait no longer; a record is sent until it is kept."""
        request.is_withdrawn = True
        if isinstance(request, Permit):
            self._waiting = [each for each in self._waiting if each is not request]

    def give_back(self, permit: Permit, unsent: AbilityRecord) -> None:
        """Do not send the goal; have the record kept that it was not sent, if it was granted."""
        self.withdraw(permit)
        if permit.is_granted:
            unsent.goal_id = f"{permit.owner}:{unsent.goal_id}"
            self.keep(unsent, RECORDER)

    # --- part of the loop

    def turn(self) -> bool:
        """Repeat what was held, or could not be kept."""
        waiting, self._waiting = self._waiting, []
        for request in waiting:
            self._attempt(request)
        return len(self._waiting) < len(waiting)

    def next_due_s(self) -> float:
        """Return never: what holds a request ends by an event."""
        return float("inf")

    def _attempt(self, request: Request) -> None:
        request.is_final = self._is_answered(request)
        if not request.is_final:
            self._waiting.append(request)

    def _is_answered(self, request: Request) -> bool:
        supervisor = self.supervisor
        if supervisor is None:
            return False
        if isinstance(request, Permit):
            asked = request.operation
            answer, why = supervisor.tasks.begin_operation(
                asked.behavior, asked.state_path, asked.ability
            )
            return request.take(BeginOperationResponse(_ANSWERS[answer], supervisor.owner, why))
        assert isinstance(request, Keeping)
        kept, request.trouble = supervisor.tasks.keep_record(
            request.record.behavior, operation_of(request.record)
        )
        return kept


_ANSWERS = {
    Answer.GRANTED: BeginOperationResponse.GRANTED,
    Answer.HELD: BeginOperationResponse.HELD,
    Answer.REFUSED: BeginOperationResponse.REFUSED,
}


class Inspection:
    """The supervisor's port to CheckConnection."""

    def __init__(self, exchange: Exchange, loop: CellLoop) -> None:
        """Take the abilities, and the loop in which their goals are done."""
        self._exchange, self._loop = exchange, loop
        self._numbers = itertools.count(1)

    def wait(self, limit_s: float) -> None:
        """It is there."""

    def is_connected(self, owner: int, wire: str, end: str, component: str, terminal: str) -> bool:
        """Return whether an end ("a" or "b") of a wire is in a terminal; raises UnseenError."""
        goal = CheckConnectionGoal(
            id=f"{owner}:check {wire} {end} {next(self._numbers)}",
            cable_id=wire,
            cable_end=end,
            component_id=component,
            terminal_id=terminal,
            timeout=INSPECTION_S,
        )
        handle = self._exchange.send(INSPECTION, goal)
        self._loop.run_until(lambda: handle.is_ended, float("inf"))
        result = handle.result
        if result is None or not result.success:
            code = result.error_code if result else Code.INTERNAL
            text = result.error_message if result else handle.text
            raise UnseenError(code or Code.INTERNAL, text, goal.id)
        return bool(result.connected)
