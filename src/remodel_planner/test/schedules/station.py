"""A station: a cell's robot and servers, and the lives of its supervisor, as ros/run_server.py."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from remodel_planner.core.cell_order import USE_CASE
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.events import Answered, Command, Commanded, Event, RunBegun
from remodel_planner.core.supervision.gate import Permit
from remodel_planner.core.supervision.state import RunState, state_after
from remodel_planner.edge.cell_ownership import CellOwnership, Owned
from remodel_planner.edge.run_log import RunLog
from remodel_planner.edge.task_leases import TaskLeases
from remodel_planner.errors import (
    CellError,
    LeavingError,
    LostError,
    OwnerError,
    PlannerError,
    RecordLostError,
)
from remodel_planner.supervisors.use_case_supervisor import Peers, UseCaseSupervisor, Work
from remodel_states.testing.operations import OPERATIONS
from schedules.cell_services import CellServices
from schedules.database import FailingDatabase, Memory
from schedules.engine import Engine
from schedules.node import Node
from schedules.planner import ORDER, SimulatedPlanner, plant
from schedules.ports import (
    SimulatedAbilities,
    SimulatedCell,
    SimulatedEngine,
    SimulatedInspection,
    SimulatedMaker,
    SimulatedPictures,
)
from schedules.process import Process
from schedules.server import Server
from schedules.simulation import Simulation
from schedules.site import Site

if TYPE_CHECKING:
    from schedules.invariants import Invariants

# [s] between two attempts to own the cell; for which cells and tasks are leased; until a process
# that ended is respawned.
_ACQUIRE_EVERY_S = 1.0
LEASE_S = 30.0
_RESPAWN_S = (0.5, 3.0)

_USED = (
    "CheckConnection",
    "DetectCable",
    "DiscardCable",
    "FixCable",
    "InsertCable",
    "LocateGearboxComponent",
    "PickCable",
    "PlaceCable",
)

Reply = Callable[[bool, str], None]


@dataclass(frozen=True)
class Setting:
    """How supervisors are set up.

    Attributes:
        count: of the order's tasks that are to be done.
        attended: whether somebody answers questions.
        question_timeout_s: [s] after which they escalate; 0: never.
        reconnect_s: [s] that what is lost gets to answer again.
    """

    count: int
    attended: bool
    question_timeout_s: float
    reconnect_s: float


class KeptLog(RunLog):
    """The run log, whose events the invariants see."""

    def __init__(self, database: FailingDatabase, station: Station, process: Process) -> None:
        """Take the database."""
        super().__init__(database)
        self._station = station
        self._process = process

    def append(self, run: int, event: Event, before: RunState, owner: int) -> RunState:
        """Keep an event."""
        after = super().append(run, event, before, owner)
        self._station.invariants.on_event(self._station, self._process, run, event, after)
        return after


class Station:
    """One robot with its processes.

    Attributes:
        cell: name of its cell; two stations may have the same by mistake.
        life: of the supervisor's process that runs; None before the first.
    """

    def __init__(
        self,
        simulation: Simulation,
        site: Site,
        memory: Memory,
        setting: Setting,
        invariants: Invariants,
        name: str,
        cell: str,
    ) -> None:
        """Start everything."""
        self.simulation = simulation
        self.site = site
        self.memory = memory
        self.setting = setting
        self.invariants = invariants
        self.name = name
        self.cell = cell
        self.servers = {
            ability: Server(simulation, site, name, cell, ability)
            for ability in _USED
            if ability in OPERATIONS
        }
        self.services = CellServices(simulation, site, name, cell)
        self.synthesizer = Node(simulation, f"{name}/synthesizer")
        self.engine = Engine(simulation, name, self.servers, self)
        self.life: Life | None = None
        self._lives = 0
        self._start()

    @property
    def nodes(self) -> tuple[Node, ...]:
        """All processes but the supervisor's."""
        return (*self.servers.values(), self.services, self.synthesizer, self.engine)

    @property
    def process(self) -> Process | None:
        """The supervisor's process; None while there is none."""
        return self.life.process if self.life and not self.life.process.is_dead else None

    @property
    def supervisor(self) -> UseCaseSupervisor | None:
        """The supervisor of the run under way."""
        return self.life.active if self.life and self.process else None

    def _start(self) -> None:
        self._lives += 1
        Process(self.simulation, f"{self.name}/sup{self._lives}", self._main, self._on_end)

    def _main(self, process: Process) -> None:
        self.life = Life(self, process)
        self.life.serve()

    def _on_end(self) -> None:
        self.simulation.after(self.simulation.random.uniform(*_RESPAWN_S), self._start)

    # --- what states and people ask

    def begin_operation(
        self,
        behavior: str,
        path: str,
        ability: str,
        answer: Callable[[tuple[Permit, int] | None], None],
    ) -> None:
        """See engine.Supervision."""

        def begin(life: Life) -> tuple[Permit, int]:
            if life.active is None:
                return (Permit.HELD if life.closed else Permit.REFUSED), 0
            permit, _ = life.active.tasks.begin_operation(behavior, path, ability)
            self.simulation.note(life.process.name, "{} {}{}", permit.value, behavior, path)
            return permit, life.active.owner

        self._request(begin, answer)

    def keep_record(
        self, behavior: str, operation: Operation, answer: Callable[[bool | None], None]
    ) -> None:
        """See engine.Supervision."""

        def keep(life: Life) -> bool:
            if life.active is None:
                return not life.closed
            return life.active.tasks.keep_record(behavior, operation)[0]

        self._request(keep, answer)

    def send_goal(
        self, count: int, answer: Callable[[str | None], None], *, again: bool = False
    ) -> None:
        """Ask for the order; the answer is why not, empty if it is done."""
        self._request(lambda life: life.take_goal(count, again=again), answer)

    def _request(self, call: Callable[[Life], object], answer: Callable[..., None]) -> None:
        latency_s = self.simulation.latency_s()
        self.simulation.after(latency_s, self._arrive, call, answer)

    def _arrive(self, call: Callable[[Life], object], answer: Callable[..., None]) -> None:
        life = self.life
        if life is None or self.process is None:
            self.simulation.after(self.simulation.latency_s(), answer, None)
            return
        life.process.request(lambda: call(life), answer)

    def command(self, event: Commanded, answer: Callable[[bool], None]) -> None:
        """Ask the supervisor for something."""
        self.simulation.note("people", "{} {} at {}", event.command.value, event.task, self.name)
        if event.command is Command.PROTECTIVE_STOP and self.process is not None:
            for server in self.servers.values():
                server.deliver(self.simulation.latency_s(), server.on_cancel)
        self._ask(lambda life, reply: life.command(event, reply), answer)

    def answer(self, event: Answered, answer: Callable[[bool], None]) -> None:
        """Answer a question."""
        self.simulation.note("people", "answer {} at {}", event.choice.value, self.name)
        self._ask(lambda life, reply: life.answer(event, reply), answer)

    def _ask(self, call: Callable[[Life, Reply], None], answer: Callable[[bool], None]) -> None:
        def on_answer(reply: tuple[bool, str] | None) -> None:
            self.simulation.note("people", "hear from {}: {}", self.name, reply)
            answer(reply is not None and reply[0])

        def arrive() -> None:
            life = self.life
            if life is None or self.process is None:
                on_answer(None)
            else:
                life.process.ask(lambda reply: call(life, reply), on_answer)

        self.simulation.after(self.simulation.latency_s(), arrive)


class Life:
    """One life of a station's supervisor.

    Attributes:
        active: supervisor of the run under way; None without one.
        closed: why nothing new is taken.
    """

    def __init__(self, station: Station, process: Process) -> None:
        """Connect to everything."""
        self.process = process
        self.active: UseCaseSupervisor | None = None
        self.closed = "starting"
        self._station = station
        self._database = FailingDatabase(station.memory, process)
        self._log = KeptLog(self._database, station, process)
        self._ownership = CellOwnership(
            self._database, station.cell, station.name, process.name, LEASE_S
        )
        self._owner = 0
        self._owned_until_s = 0.0
        self._disowned = ""
        self._unsure = True
        self._next: UseCaseSupervisor | None = None
        servers = station.servers
        self._peers = Peers(
            SimulatedCell(process, station.services),
            SimulatedMaker(process, station.synthesizer, station.engine.behaviors),
            SimulatedEngine(process, station.engine),
            SimulatedAbilities(process, servers),
            SimulatedInspection(process, servers["CheckConnection"]),
            SimulatedPictures(),
        )

    def serve(self) -> None:
        """Supervise runs until the process ends."""
        self.process.every(self._ownership.lease_s / 3, self._renew)
        try:
            while True:
                try:
                    self._acquire()
                    self._supervise_runs()
                except (OwnerError, RecordLostError) as error:
                    self._note("gives up: {}", error)
                    self.active, self._owner, self.closed = None, 0, str(error)
                except LostError as error:
                    # The real node ends, and is respawned.
                    self._note("ends: {}", error)
                    return
        except LeavingError:
            with contextlib.suppress(PlannerError):
                if self._owner:
                    self._ownership.release(self._owner)

    def _note(self, what: str, *args: object) -> None:
        self._station.simulation.note(self.process.name, what, *args)

    def _acquire(self) -> None:
        while True:
            asked_s = self.process.wall_s()
            try:
                found = self._ownership.acquire()
                if isinstance(found, Owned):
                    break
                self.closed = f"owned by {found.holder}"
            except LostError as error:
                self.closed = str(error)
            self.process.run_until(lambda: False, _ACQUIRE_EVERY_S)
        self._note("owns {} with token {}", self._station.cell, found.token)
        self._owner = found.token
        self._owned_until_s = asked_s + self._ownership.lease_s
        self._disowned = ""

    def _renew(self) -> None:
        if not self._owner:
            return
        asked_s = self.process.wall_s()
        with contextlib.suppress(LostError):
            if not self._ownership.renew(self._owner):
                self._disowned = "another supervisor owns the cell now"
                return
            self._owned_until_s = asked_s + self._ownership.lease_s

    def _why_disowned(self) -> str:
        if not self._disowned and self.process.wall_s() > self._owned_until_s:
            return "the ownership could not be renewed: the database does not answer"
        return self._disowned

    def _supervise_runs(self) -> None:
        self._unsure = True
        while True:
            if self._unsure:
                self._resume()
            self.closed = ""
            self.process.run_until(
                lambda: self._next is not None or self._unsure or bool(self._disowned),
                float("inf"),
            )
            if self._next is not None:
                self._supervise(self._next)
            elif not self._unsure:
                raise OwnerError(self._disowned)

    def _resume(self) -> None:
        unfinished = self._log.unfinished(self._station.cell)
        self._unsure = False
        if unfinished is not None:
            self._supervise(self._resumed(unfinished))

    def _resumed(self, run: int) -> UseCaseSupervisor:
        self._log.take_up(run, self._owner)
        state = self._log.state(run)
        self._station.invariants.on_take_up(run, state)
        self._note("resumes run {}", run)
        return self._made(run, state)

    def _made(self, run: int, state: RunState) -> UseCaseSupervisor:
        setting = self._station.setting
        leases = TaskLeases(
            self._database, ORDER.name, self._station.cell, LEASE_S, self._owner
        )
        work = Work(
            planner=SimulatedPlanner(len(state.tasks), setting.question_timeout_s),  # type: ignore[arg-type]
            faults=plant().faults,
            panel=True,
            channels=plant().channels,
            leases=leases,
            attended=setting.attended,
            reconnect_s=setting.reconnect_s,
        )
        return UseCaseSupervisor(
            run,
            self._owner,
            state,
            self.process,
            self._log,
            work,
            self._peers,
            lambda: None,
            self._why_disowned,
        )

    def _supervise(self, supervisor: UseCaseSupervisor) -> None:
        self.active, self._next = supervisor, None
        state = supervisor.supervise()
        self.active = None
        self._station.invariants.on_end(self._station, supervisor.run, state)

    def take_goal(self, count: int, *, again: bool) -> str:
        """Begin a run; return why not, empty if it is begun."""
        under_way = self.active or self._next
        if under_way is not None:
            return f"run {under_way.run} is under way"
        if self.closed:
            return self.closed
        setting = self._station.setting
        planner = SimulatedPlanner(count, setting.question_timeout_s)
        begun = RunBegun(ORDER.name, USE_CASE, self._station.cell, planner.names)
        try:
            run, begun = self._log.begin(begun, self._owner, again=again)
        except LostError as error:
            self._unsure = True
            self._station.invariants.on_unsure(self._station)
            return str(error)
        except PlannerError as error:
            return str(error)
        self._note("begins run {}: {}", run, begun)
        self._station.invariants.on_begin(self._station, run, begun)
        self._next = self._made(run, state_after([begun]))
        return ""

    def command(self, event: Commanded, reply: Reply) -> None:
        """Do what somebody asks for."""
        if self.active is None:
            reply(False, self.closed or "no run is under way")
        else:
            self.active.command(event, reply)

    def answer(self, event: Answered, reply: Reply) -> None:
        """Take an operator's answer."""
        if self.active is None:
            reply(False, "no run is under way")
        else:
            self.active.answer(event, reply)


__all__ = ["LEASE_S", "CellError", "Life", "Setting", "Station"]
