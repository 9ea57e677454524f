"""The supervisors' ports to the simulated world."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from remodel_msgs.msg import ErrorCode

from flexbe_synthesizer.core.chart.model import Chart
from remodel_production.errors import LostError
from remodel_states.core.codes import Code
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.state import PERSON_FIRST
from remodel_supervision.errors import RefusedError
from remodel_supervision.supervisors.ports import BehaviorEnd, Doing, EndKind, UnseenError
from remodel_tasks.core.task_charts.planned_tasks import Demands
from schedules.cell_services import CellServices
from schedules.engine import Engine
from schedules.node import Node
from schedules.process import Process
from schedules.server import Goal, Result, Server
from schedules.site import Motion

# [s] without a sign of the engine after which it counts as lost, and as not answering.
_SILENCE_LIMIT_S = 15.0
_FRESH_S = 3.0

# [s] that an inspection gets, and that synthesis takes.
_INSPECTION_LIMIT_S = 30.0
_SYNTHESIS_LIMIT_S = 10.0


def _wait(process: Process, node: Node, limit_s: float) -> None:
    process.step()
    if not process.run_until(lambda: node.is_up, limit_s):
        raise LostError(f"{node.name} is not there after {limit_s:.0f} s")


class SimulatedEngine:
    """One supervisor's line to the engine."""

    def __init__(self, process: Process, engine: Engine) -> None:
        self.state_path = ""
        self._process = process
        self._engine = engine
        self._number = 0
        # Of an engine that was silent before nothing is known.
        self._counted_s = 0.0 if engine.answers else _FRESH_S + 1.0
        process.every(1.0, self._count)
        self._end: BehaviorEnd | None = None
        self._path: list[str] = []

    @property
    def end(self) -> BehaviorEnd | None:
        return self._end

    @property
    def trouble(self) -> str:
        self._process.require_alive()
        if not self._engine.is_up:
            return "the engine has gone"
        if self._silent_s > _SILENCE_LIMIT_S:
            return f"the engine has been silent for {self._silent_s:.0f} s"
        return ""

    @property
    def is_idle(self) -> bool:
        """Whether the engine has reported lately that it runs nothing."""
        self._process.require_alive()
        is_fresh = self._engine.is_up and self._silent_s <= _FRESH_S
        return is_fresh and not self._engine.is_running

    @property
    def _silent_s(self) -> float:
        """How long it has been silent while this process listened [s]."""
        return 0.0 if self._engine.answers else self._counted_s

    def _count(self) -> None:
        """Count its silence, as long as this process is not stalled itself."""
        self._counted_s = 0.0 if self._engine.answers else self._counted_s + 1.0

    def wait(self, limit_s: float) -> None:
        self._process.step()
        self._process.run_until(lambda: not self.trouble and self._silent_s <= _FRESH_S, limit_s)
        if self.trouble or self._silent_s > _FRESH_S:
            raise LostError(self.trouble or "the engine does not answer")

    def start(self, behavior: str) -> None:
        self._process.step()
        self._number += 1
        self._end, self._path = None, []
        latency_s = self._process.simulation.latency_s()
        if self._engine.is_up:
            self._engine.deliver(latency_s, self._engine.on_start, self, self._number, behavior)
        else:
            lost = BehaviorEnd(EndKind.LOST, "the engine's action server lost the behavior")
            self._process.simulation.after(latency_s, self.on_end, self._number, lost)
        self._process.step()

    def cancel(self, *, own_only: bool = False) -> None:
        self._process.step()
        if not own_only and self._process.is_leaving:
            self._engine.has_late_stop = True  # it stalled after it had decided to stop everything
        own = (self, self._number) if own_only else ()
        self._engine.deliver(self._process.simulation.latency_s(), self._engine.on_cancel, *own)

    def path(self) -> tuple[str, ...]:
        return tuple(self._path)

    def on_entered(self, number: int, path: str) -> None:
        if number == self._number:
            self._path.append(path)

    def on_end(self, number: int, end: BehaviorEnd) -> None:
        if number == self._number and self._end is None:
            self._end = end
            self._process.post(lambda: None)


class SimulatedAbilities:
    """One supervisor's view of the ability servers."""

    latest: Doing | None = None

    def __init__(
        self,
        process: Process,
        servers: Mapping[str, Server],
        on_heard: Callable[[Motion, Process], None],
    ) -> None:
        """Listen to all of them; `on_heard` is called with motions that a person is to clear."""
        self._process = process
        self._on_heard = on_heard
        self._servers = servers
        self._stops: list[Operation] = []
        for server in servers.values():
            server.listeners.append(self._on_result)

    def cancel(self, owner: int | None = None) -> None:
        self._process.step()
        for server in self._servers.values():
            server.deliver(self._process.simulation.latency_s(), server.on_cancel, "", owner)

    def are_quiet(self, since_s: float, owner: int | None = None) -> bool:
        return not self.restless(since_s, owner)

    def answers(self, ability: str, since_s: float) -> bool:
        server = self._servers[ability]
        return server.is_up and server.rests(since_s)

    def is_connected(self, ability: str) -> bool:
        return self._servers[ability].is_up

    def restless(self, since_s: float, owner: int | None = None) -> tuple[str, ...]:
        """Return the names of those that do not rest or report."""
        servers = [server for server in self._servers.values() if server.is_up]
        return tuple(s.name for s in servers if not s.rests(since_s, owner))

    def take_stops(self) -> tuple[Operation, ...]:
        stops, self._stops = self._stops, []
        return tuple(stops)

    def _on_result(self, motion: Motion, operation: Operation) -> None:
        if operation.error_code in PERSON_FIRST - {Code.STALE_OWNER} and not self._process.is_dead:
            self._stops.append(operation)
            self._on_heard(motion, self._process)


class SimulatedCell:
    """One supervisor's line to the cell's services."""

    def __init__(self, process: Process, services: CellServices) -> None:
        self._process = process
        self._services = services

    def wait(self, limit_s: float) -> None:
        _wait(self._process, self._services, limit_s)

    def address(self) -> str:
        self._process.step()
        if not self._services.is_up:
            raise LostError("the cell does not answer")
        return f"cell:{self._services.life}"

    def load(self, panel: object, serial: str, owner: int, *, demands: Demands, keep: bool) -> None:
        self._ask(self._services.on_load, serial, owner, keep)

    def feed(self, wire: str, owner: int) -> None:
        self._ask(self._services.on_feed, wire, owner)

    def take_over(self, owner: int) -> bool:
        try:
            self._ask(self._services.on_take_over, owner)
        except RefusedError as error:
            return error.code != Code.BUSY
        return True

    def placed(self, wire: str) -> bool | None:
        self._process.step()
        if not self._services.is_up:
            raise LostError("cannot ask for the ground truth")
        world = self._services.world
        return world.is_placed(wire) if wire in world.fed else None

    def _ask(self, call: Callable[..., None], *args: object) -> None:
        process, services = self._process, self._services
        process.step()

        def begin(done: Callable[[object], None]) -> None:
            if not services.is_up:
                process.simulation.after(0.02, done, _GONE)
                return
            services.on_death(lambda: process.simulation.after(0.02, done, _GONE))
            latency_s = process.simulation.latency_s()
            services.deliver(
                latency_s,
                call,
                *args,
                lambda error: process.simulation.after(latency_s, done, error),
            )

        result: Any = process.background(begin)
        process.step()
        if result is _GONE:
            raise LostError(f"{services.name} has gone")
        if result is not None:
            raise RefusedError(result.code, str(result))


class SimulatedMaker:
    """One supervisor's line to the synthesizer."""

    def __init__(self, process: Process, synthesizer: Node, behaviors: dict[str, Chart]) -> None:
        self._process = process
        self._synthesizer = synthesizer
        self._behaviors = behaviors

    def wait(self, limit_s: float) -> None:
        _wait(self._process, self._synthesizer, limit_s)

    def make(self, chart: Chart) -> None:
        """Have a chart's behavior made, unless it exists."""
        process = self._process
        process.step()
        if self._behaviors.get(chart.name) is chart:
            return

        def begin(done: Callable[[bool], None]) -> None:
            if self._synthesizer.is_up:
                self._synthesizer.on_death(lambda: process.simulation.after(0.02, done, False))
                self._synthesizer.deliver(0.05, done, True)
                process.simulation.after(_SYNTHESIS_LIMIT_S, done, False)
            else:
                process.simulation.after(_SYNTHESIS_LIMIT_S, done, False)

        if not process.background(begin):
            raise LostError("the synthesizer does not answer")
        self._behaviors[chart.name] = chart


class SimulatedInspection:
    """One supervisor's line to the ability CheckConnection."""

    def __init__(self, process: Process, server: Server) -> None:
        self._process = process
        self._server = server
        self._count = 0

    def wait(self, limit_s: float) -> None:
        _wait(self._process, self._server, limit_s)

    def is_connected(self, owner: int, wire: str, end: str, component: str, terminal: str) -> bool:
        process, server = self._process, self._server
        process.step()
        self._count += 1
        goal = Goal(
            f"{owner}:check {wire} {end} {self._count}", wire, end, component, terminal_id=terminal
        )

        def begin(done: Callable[[Result], None]) -> None:
            if not server.is_up:
                process.simulation.after(0.02, done, _LOST_GOAL)
                return
            server.on_death(lambda: process.simulation.after(0.02, done, _LOST_GOAL))
            latency_s = process.simulation.latency_s()
            server.deliver(
                latency_s,
                server.on_goal,
                goal,
                lambda result: process.simulation.after(latency_s, done, result),
            )
            process.simulation.after(_INSPECTION_LIMIT_S, done, _LOST_GOAL)

        result = process.background(begin)
        process.step()
        if result is _LOST_GOAL:
            server.deliver(process.simulation.latency_s(), server.on_cancel, goal.id)
            raise LostError(f"{server.name} has gone, or took too long")
        if result.code or not result.success:
            raise UnseenError(result.code or ErrorCode.INTERNAL, result.text, goal.id)
        return bool(result.found["connected"])


class SimulatedPictures:
    """No pictures."""

    def begin(self) -> None:
        """Forget nothing."""

    def keep(self, run: int, label: str) -> tuple[str, ...]:
        return ()


@dataclass(frozen=True)
class _Gone:
    """No answer."""


_GONE = _Gone()
_LOST_GOAL = Result(False, ErrorCode.SERVER_LOST, "lost")
