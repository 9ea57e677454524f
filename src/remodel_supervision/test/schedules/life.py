"""A life of a supervisor's process, as ros/server/run_server.py leads it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from remodel_planning.core.orders.cell_order import USE_CASE
from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.errors import LostError, OwnerError, PlannerError, RecordLostError
from remodel_supervision.core.runs.events import Answered, Commanded, Event, RunBegun
from remodel_supervision.core.runs.fold import state_after
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.edge.task_leases import TaskLeases
from remodel_supervision.errors import LeavingError
from remodel_supervision.supervisors.run_commands import RunCommands
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.unresumed_run import UnresumedRun
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor
from remodel_supervision.supervisors.work import Peers, Work
from schedules.database import FailingDatabase
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

if TYPE_CHECKING:
    from schedules.station import Station

# [s] between two attempts to own the cell; for which cells and tasks are leased.
_ACQUIRE_EVERY_S = 1.0
LEASE_S = 30.0


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


class Life:
    """One life of a station's supervisor.

    Attributes:
        active: supervisor of the run under way; None without one.
        closed: why nothing new is taken.
        commands: does what is commanded.
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
        abilities = SimulatedAbilities(process, servers, station.invariants.on_heard)
        self.commands = RunCommands(
            process,
            abilities,
            lambda: self.active,
            lambda: self.closed,
            station.stopped_by,
            station.keep_stops,
        )
        self._peers = Peers(
            SimulatedCell(process, station.services),
            SimulatedMaker(process, station.synthesizer, station.engine.behaviors),
            SimulatedEngine(process, station.engine),
            abilities,
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
        supervisor = None if unfinished is None else self._resumed(unfinished)
        if supervisor is not None:
            self._supervise(supervisor)

    def _resumed(self, run: int) -> UseCaseSupervisor | None:
        self._log.take_up(run, self._owner)
        state = self._log.state(run)
        self._station.invariants.on_take_up(run, state)
        if self.process.simulation.now_s < self._station.unmade_until_s:
            self._await_person(UnresumedRun(run, self._owner, state, self._log, "no use case"))
            return None
        self._note("resumes run {}", run)
        return self._made(run, state)

    def _await_person(self, unresumed: UnresumedRun) -> None:
        self._note("{}", unresumed.text)
        self._peers.engine.cancel()
        self._peers.abilities.cancel()
        self.closed, self.commands.unresumed = unresumed.text, unresumed
        try:
            self.process.run_until(lambda: unresumed.is_over or bool(self._disowned), float("inf"))
        finally:
            self.commands.unresumed = None
        self._unsure = True
        if self._disowned:
            raise OwnerError(self._disowned)

    def _made(self, run: int, state: RunState) -> UseCaseSupervisor:
        setting = self._station.setting
        leases = TaskLeases(self._database, ORDER.name, self._station.cell, LEASE_S, self._owner)
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
            RunRecord(run, self._owner, state, self._log, loop=self.process),
            self.process,
            work,
            self._peers,
            on_change=lambda: None,
            disowned=self._why_disowned,
        )

    def _supervise(self, supervisor: UseCaseSupervisor) -> None:
        self.active, self._next = supervisor, None
        self.commands.stop_if_unsafe()
        state = supervisor.supervise()
        self.active = None
        self._station.invariants.on_end(self._station, supervisor.run, state)

    def take_goal(self, count: int, *, again: bool) -> str:
        """Begin a run; return why not, empty if it is begun."""
        under_way = self.active or self._next
        if under_way is not None:
            return f"run {under_way.run} is under way"
        if why := self.closed or self.commands.safety:
            return why
        setting = self._station.setting
        planner = SimulatedPlanner(count, setting.question_timeout_s)
        begun = RunBegun(ORDER.name, USE_CASE, self._station.cell, planner.names)
        try:
            run, begun = self._log.begin(begun, self._owner, again=again)
        except LostError as error:
            self._unsure = True
            return str(error)
        except PlannerError as error:
            return str(error)
        self._note("begins run {}: {}", run, begun)
        self._station.invariants.on_begin(self._station, run, begun)
        self._next = self._made(run, state_after([begun]))
        return ""

    def command(self, event: Commanded, reply: Reply) -> None:
        """Do what somebody asks for."""
        self.commands.command(event, reply)

    def answer(self, event: Answered, reply: Reply) -> None:
        """Take an operator's answer."""
        if self.active is None:
            reply(False, "no run is under way")
        else:
            self.active.answer(event, reply)
