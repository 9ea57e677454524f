"""The simulated behavior engine with its action server: runs flat charts of ability states."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from remodel_msgs.msg import ErrorCode

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.model import Node as ChartNode
from remodel_states.core.contract import GRACE_S
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind
from schedules.node import Node
from schedules.server import Goal, Result, Server
from schedules.simulation import Simulation

# [s] between two attempts of a request, and until the end of a server's connection is noticed.
_RETRY_S = 0.25
_NOTICED_S = (0.02, 0.3)

Callback = Callable[[Any], None]


class Supervision(Protocol):
    """What the states of behaviors ask a supervisor, whichever runs."""

    def begin_operation(self, behavior: str, path: str, ability: str, answer: Callback) -> None:
        """Answer with (Permit, owner), or None without an answer."""

    def keep_record(self, behavior: str, operation: Operation, answer: Callback) -> None:
        """Answer whether it is kept, or None without an answer."""

    def on_engine_death(self) -> None:
        """Hear that records that were not kept are lost."""


class Client(Protocol):
    """Who starts behaviors."""

    def on_entered(self, number: int, path: str) -> None:
        """Hear which state was entered."""

    def on_end(self, number: int, end: BehaviorEnd) -> None:
        """Hear how a behavior ended."""


class PreemptedError(Exception):
    """The behavior is to stop."""


@dataclass
class _Run:
    """A behavior that runs."""

    number: int
    chart: Chart
    client: Client
    steps: Generator[Callable[[Callback], None], Any, None] | None = None
    ticket: int = 0
    sent: Counter[str] = field(default_factory=Counter)
    is_over: bool = False


class Engine(Node):
    """Runs one behavior at a time.

    Attributes:
        behaviors: charts of those that exist, by name.
        has_late_stop: whether a supervisor that another one has replaced has stopped what runs.
    """

    def __init__(
        self, simulation: Simulation, station: str, servers: Mapping[str, Server], up: Supervision
    ) -> None:
        super().__init__(simulation, f"{station}/engine")
        self.behaviors: dict[str, Chart] = {}
        self.has_late_stop = False
        self._servers = servers
        self._up = up
        self._run: _Run | None = None
        self._arrivals: dict[Callable[..., None], float] = {}
        # Records of states that were left, which are sent until they are kept.
        self._unkept: list[tuple[str, Operation]] = []

    @property
    def is_running(self) -> bool:
        return self._run is not None

    def on_start(self, client: Client, number: int, behavior: str) -> None:
        if self._run is not None or behavior not in self.behaviors:
            text = f"{behavior} cannot be started"
            self._send(client.on_end, number, BehaviorEnd(EndKind.FAILED, text))
            return
        self.simulation.note(self.name, "starts {}", behavior)
        self._run = run = _Run(number, self.behaviors[behavior], client)
        run.steps = self._behave(run)
        self._resume(run, 0, None)

    def on_cancel(self, client: Client | None = None, number: int = 0) -> None:
        """Stop whatever runs, or what a client has started, when the engine gets to it."""
        if self._run is not None and (
            client is None or (client, number) == (self._run.client, self._run.number)
        ):
            run = self._run
            self.deliver(self.simulation.random.uniform(0.0, 0.15), self._preempt, run)

    def died(self) -> None:
        """Forget the behavior; its client learns that when the engine is up again."""
        self._lost, self._run = self._run, None
        self._unkept.clear()
        self._up.on_engine_death()

    def restarted(self) -> None:
        """Report that the goal of the last life is not known."""
        run, self._lost = self._lost, None
        if run is not None:
            text = "the engine's action server lost the behavior"
            self._send(run.client.on_end, run.number, BehaviorEnd(EndKind.LOST, text))

    _lost: _Run | None = None

    # --- a behavior

    def _behave(self, run: _Run) -> Generator[Callable[[Callback], None], Any, None]:
        nodes = {node.id: node for node in run.chart.nodes}
        visits: Counter[str] = Counter()
        current = run.chart.initial
        while current in nodes:
            node = nodes[current]
            targets = {each.event: each.target for each in node.transitions}
            visits[current] += 1
            if node.attempts is not None and visits[current] > node.attempts:
                current = targets["exhausted"]
                continue
            self._send(run.client.on_entered, run.number, f"/{node.id}")
            event = yield from self._state(run, node)
            current = targets[event]
        self._finish(run, BehaviorEnd(EndKind.FINISHED, current))

    def _state(self, run: _Run, node: ChartNode) -> Generator[Callable[[Callback], None], Any, str]:
        """Run an ability state; return its outcome."""
        path, ability, name = f"/{node.id}", node.type, run.chart.name
        run.sent[path] += 1
        goal = Goal(**{each.name: each.value for each in node.params})  # type: ignore[arg-type]
        goal.id = f"{name}{path}#{run.sent[path]}"
        permit, owner = yield from self._permitted(run, path, ability, goal)
        if permit is Permit.REFUSED:
            return "command_error"
        goal.id = f"{owner}:{goal.id}"
        begun_s = self.simulation.now_s
        server = self._servers[ability]
        try:
            result = yield lambda answer: self._call(server, goal, answer)
        except PreemptedError:
            server.deliver(self.simulation.latency_s(), server.on_cancel, goal.id)
            result = Result(False, ErrorCode.PREEMPTED, "the state was left")
            self._keep_left(
                name, self._operation(path, ability, goal, "", result=result, begun_s=begun_s)
            )
            raise
        if result in (_GONE, _HUNG):
            server.deliver(self.simulation.latency_s(), server.on_cancel, goal.id)
        outcome = _outcome_of(result)
        operation = self._operation(path, ability, goal, outcome, result=result, begun_s=begun_s)
        try:
            while True:
                is_kept = yield lambda answer: self._up.keep_record(name, operation, answer)
                if is_kept and not self.simulation.chance(self.simulation.duplicates):
                    return outcome
                yield lambda answer: self.deliver(_RETRY_S, answer, None)
        except PreemptedError:
            self._keep_left(name, operation)
            raise

    def _keep_left(self, behavior: str, operation: Operation) -> None:
        """Send the record of a state that was left, until it is kept."""
        record = behavior, operation
        self._unkept.append(record)
        life = self.life

        def send() -> None:
            if self.is_up and life == self.life:
                self._up.keep_record(*record, on_answer)

        def on_answer(is_kept: bool | None) -> None:
            if not self.is_up or life != self.life:
                return  # the record died with the engine
            if is_kept:
                self._unkept.remove(record)
            else:
                self.deliver(_RETRY_S, send)

        send()

    def _permitted(
        self, run: _Run, path: str, ability: str, goal: Goal
    ) -> Generator[Callable[[Callback], None], Any, tuple[Permit, int]]:
        name = run.chart.name
        is_left = False

        def ask(answer: Callback) -> None:
            def on_answer(permitted: tuple[Permit, int] | None) -> None:
                if is_left and permitted is not None and permitted[0] is Permit.GRANTED:
                    goal.id = f"{permitted[1]}:{goal.id}"
                    unsent = Result(False, ErrorCode.PREEMPTED, "left before its goal was sent")
                    now_s = self.simulation.now_s
                    record = self._operation(path, ability, goal, "", result=unsent, begun_s=now_s)
                    self._keep_left(name, record)
                else:
                    answer(permitted)

            if self._unkept:
                self.deliver(_RETRY_S, answer, None)
            else:
                self._up.begin_operation(name, path, ability, on_answer)

        try:
            while True:
                permitted = yield ask
                if self.simulation.chance(self.simulation.duplicates):
                    permitted = None  # the answer was lost: it asks again
                if permitted is not None and permitted[0] is not Permit.HELD:
                    return permitted
                yield lambda answer: self.deliver(_RETRY_S, answer, None)
        except PreemptedError:
            is_left = True
            raise

    def _call(self, server: Server, goal: Goal, answer: Callback) -> None:
        simulation, life = self.simulation, self.life
        if not server.is_up:
            server.miss(goal)
            self.deliver(0.02, answer, _GONE)
            return

        def reply(result: Result) -> None:
            if life == self.life:
                self.deliver(simulation.latency_s(), answer, result)

        server.deliver(simulation.latency_s(), server.on_goal, goal, reply)
        server.on_death(
            lambda: (
                life == self.life
                and self.deliver(simulation.random.uniform(*_NOTICED_S), answer, _GONE)
            )
        )
        self.deliver(goal.timeout + GRACE_S, answer, _HUNG)

    def _operation(
        self, path: str, ability: str, goal: Goal, outcome: str, result: Result, begun_s: float
    ) -> Operation:
        now_s = self.simulation.now_s
        code = ErrorCode.CONTRADICTORY_RESULT if result.success and result.code else result.code
        parameters = tuple(
            (name, str(value)) for name, value in vars(goal).items() if name in _DESCRIBED
        )
        return Operation(
            path,
            ability,
            outcome,
            code,
            text=result.text,
            ended_s=now_s,
            elapsed_s=now_s - begun_s,
            goal_id=goal.id,
            parameters=parameters,
        )

    # --- its course

    def _resume(self, run: _Run, ticket: int, value: object) -> None:
        if run is not self._run or run.is_over or ticket != run.ticket or run.steps is None:
            return
        run.ticket += 1
        ticket = run.ticket
        try:
            wait = run.steps.send(value)
        except StopIteration:
            return
        wait(lambda answer: self.deliver(0.0, self._resume, run, ticket, answer))

    def _preempt(self, run: _Run) -> None:
        if run is not self._run or run.is_over or run.steps is None:
            return
        run.ticket += 1
        with contextlib.suppress(PreemptedError, StopIteration):
            run.steps.throw(PreemptedError())
        self._finish(run, BehaviorEnd(EndKind.PREEMPTED, "preempted"))

    def _finish(self, run: _Run, end: BehaviorEnd) -> None:
        run.is_over = True
        self._run = None
        self.simulation.note(self.name, "ended {}: {} {}", run.chart.name, end.end.value, end.text)
        self._send(run.client.on_end, run.number, end)

    def _send(self, call: Callable[..., None], *args: object) -> None:
        """Publish; the messages of a topic arrive in the order in which they were sent."""
        arrives_s = self.simulation.now_s + self.simulation.latency_s()
        self._arrivals[call] = max(arrives_s, self._arrivals.get(call, 0.0))
        self.simulation.at(self._arrivals[call], call, *args)


_GONE = Result(False, ErrorCode.SERVER_LOST, "the server went away", refused=True)
_HUNG = Result(False, ErrorCode.SERVER_HUNG, "the server did not end the goal")
_DESCRIBED = ("force_limit", "pull_test_force", "grasp_distance", "view")


def _outcome_of(result: Result) -> str:
    if result.refused:
        return "command_error"
    return "done" if result.success and not result.code else "failed"
