"""A life of a supervisor's process: the runs of its cell over simulated ports."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

from remodel_production.edge.database.cell_ownership import CellOwnership
from remodel_production.errors import LostError, PlannerError
from remodel_supervision.core.runs.events import Answered, Commanded, Event, RunBegun
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.edge.task_leases import TaskLeases
from remodel_supervision.supervisors.cell_runs import CellRuns, OwnedCell
from remodel_supervision.supervisors.ports import Peers, Work
from remodel_supervision.supervisors.run_commands import RunCommands
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor
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

# [s] for which cells and tasks are leased.
LEASE_S = 30.0

Reply = Callable[[bool, str], None]


@dataclass(frozen=True)
class Setting:
    """How supervisors are set up.

    Attributes:
        count: of the order's tasks that are to be done.
        attended: whether an operator answers questions.
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
        super().__init__(database)
        self._station = station
        self._process = process

    def append(self, run: int, event: Event, before: RunState, owner: int) -> RunState:
        after = super().append(run, event, before, owner)
        self._station.invariants.on_event(self._station, self._process, run, event, after=after)
        return after

    def begin(self, event: RunBegun, owner: int, *, again: bool = False) -> tuple[int, RunBegun]:
        run, begun = super().begin(event, owner, again=again)
        self._station.simulation.note(self._process.name, "begins run {}: {}", run, begun)
        self._station.invariants.on_begin(self._station, run, begun)
        return run, begun


class SimulatedWork:
    """Makes what a run is about; at times it cannot, since its use case cannot be read."""

    def __init__(self, station: Station, database: FailingDatabase) -> None:
        self._station = station
        self._database = database

    def work(self, name: str, use_case: str, tasks: int | Collection[str], owner: int) -> Work:
        station, setting = self._station, self._station.setting
        if station.simulation.now_s < station.unmade_until_s:
            raise PlannerError("no use case")
        count = tasks if isinstance(tasks, int) else len(tasks)
        return Work(
            planner=SimulatedPlanner(count, setting.question_timeout_s),  # type: ignore[arg-type]
            faults=plant().faults,
            panel=True,
            leases=TaskLeases(self._database, name, station.cell, LEASE_S, token=owner),
            attended=setting.attended,
            reconnect_s=setting.reconnect_s,
        )


class Life:
    """One life of a station's supervisor; see RunObserver.

    Attributes:
        process: that lives it.
        commands: reach the run under way, and hold the cell.
    """

    def __init__(self, station: Station, process: Process) -> None:
        self.process = process
        self._station = station
        database = FailingDatabase(station.memory, process)
        servers = station.servers
        abilities = SimulatedAbilities(process, servers, station.invariants.on_heard)
        self.commands = RunCommands(process, abilities, station.stopped_by, station.keep_stops)
        ownership = CellOwnership(
            database, station.cell, station.name, process.name, lease_s=LEASE_S
        )
        self._cell = OwnedCell(station.cell, ownership, process)
        self._runs = CellRuns(
            self._cell,
            process,
            KeptLog(database, station, process),
            SimulatedWork(station, database),
            peers=Peers(
                SimulatedCell(process, station.services),
                SimulatedMaker(process, station.synthesizer, station.engine.behaviors),
                SimulatedEngine(process, station.engine),
                abilities,
                inspection=SimulatedInspection(process, servers["CheckConnection"]),
                pictures=SimulatedPictures(),
            ),
            commands=self.commands,
            observer=self,
        )

    @property
    def active(self) -> UseCaseSupervisor | None:
        """The supervisor of the run under way; None without one."""
        return self.commands.active

    @property
    def closed(self) -> str:
        return self.commands.closed

    def serve(self) -> None:
        try:
            self._runs.serve()
        except LostError as error:
            # The real node ends, and is respawned.
            self._note("ends: {}", error)

    def take_goal(self, count: int, *, again: bool) -> str:
        """Begin a run; return why not, empty if it is begun."""
        try:
            self._runs.require_free()
            self._runs.begin(ORDER.name, count, again=again)
        except PlannerError as error:
            return str(error)
        return ""

    def command(self, event: Commanded, reply: Reply) -> None:
        self.commands.command(event, reply)

    def answer(self, event: Answered, reply: Reply) -> None:
        if self.active is None:
            reply(False, "no run is under way")
        else:
            self.active.answer(event, reply)

    # --- RunObserver

    def on_idle(self, text: str, *, starting: bool) -> None:
        self._note("is idle with token {}: {}", self._cell.token, text)

    def on_resume(self, run: int, state: RunState) -> None:
        self._note("resumes run {}", run)
        self._station.invariants.on_take_up(self._station, run, state)

    def on_begin(self, supervisor: UseCaseSupervisor) -> None:
        """Do nothing: states always ask."""

    def on_change(self) -> None:
        """Do nothing: no test reads what is published."""

    def on_end(self, supervisor: UseCaseSupervisor) -> None:
        self._station.invariants.on_end(self._station, supervisor.run, supervisor.state)

    def on_give_up(self, error: PlannerError) -> None:
        self._note("gives up: {}", error)

    def _note(self, what: str, *args: object) -> None:
        self._station.simulation.note(self.process.name, what, *args)
