"""What must hold, whatever happens."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from remodel_states.core.codes import Code
from remodel_states.testing.world import Deed, Entry
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Answered,
    Command,
    Commanded,
    Escalated,
    Event,
    OperationEnded,
    Part,
    RunBegun,
    RunEnded,
    Settled,
    StopReported,
    TaskBegun,
)
from remodel_supervision.core.runs.state import PERSON_FIRST, RunState, Stage
from remodel_supervision.edge.run_log import RunLog
from schedules.simulation import Simulation
from schedules.site import Motion, Site

if TYPE_CHECKING:
    from schedules.process import Process
    from schedules.station import Station

_CLOSING = (Command.PAUSE, Command.STOP, Command.PROTECTIVE_STOP)


@dataclass
class Stop:
    """A motion that ended so that a person is to answer before anything moves.

    Attributes:
        text: for a person.
        is_kept: whether a run's log has it.
        heard_by: process of a supervisor that has heard its result; None: none has.
        has_record: whether the engine lives that is to send its record.
    """

    motion: Motion
    text: str
    is_kept: bool = False
    heard_by: Process | None = None
    has_record: bool = True

    @property
    def is_lost(self) -> bool:
        """Whether no living process knows of it."""
        is_heard = self.heard_by is not None and not self.heard_by.is_dead
        return not (self.is_kept or self.has_record or is_heard)


@dataclass
class Invariants:
    """Watches a schedule, and ends it at the first violation.

    Attributes:
        states: run -> what is known of it after its last event.
        ended: runs that a supervisor has taken to their end.
        closed: station -> why its gate is closed, as a client was answered.
        stopped: station -> what a person is to answer before anything moves.
    """

    simulation: Simulation
    site: Site
    log: RunLog
    states: dict[int, RunState] = field(default_factory=dict)
    ended: dict[int, RunState] = field(default_factory=dict)
    closed: dict[str, str] = field(default_factory=dict)
    stopped: dict[str, Stop] = field(default_factory=dict)
    _engine_died_s: dict[str, float] = field(default_factory=dict)
    _closed_cells: dict[str, str] = field(default_factory=dict)
    _fixed: set[str] = field(default_factory=set)
    _discards: set[str] = field(default_factory=set)
    _begun: set[int] = field(default_factory=set)
    _serial: str = ""

    def __post_init__(self) -> None:
        self.site.on_motion = self._on_motion
        self.site.on_result = self._on_result
        self.site.on_entry = self._on_entry

    # --- the log

    def on_begin(self, station: Station, run: int, event: RunBegun) -> None:
        if self.closed.pop(station.name, "") == Command.PROTECTIVE_STOP.value:
            self.simulation.violated(f"run {run} begins during a protective stop")
        self._begun.add(run)
        self.states[run] = state_after([event])

    def on_goal(self, station: Station) -> None:
        """Note that a client requests another run: what was stopped may continue in it."""
        if self.closed.get(station.name) == Command.STOP.value:
            del self.closed[station.name]

    def on_take_up(self, station: Station, run: int, state: RunState) -> None:
        """Learn the state of a run; its last event may have gone unnoticed."""
        is_new = run not in self._begun  # its beginning went unnoticed
        self._begun.add(run)
        if is_new and self.closed.get(station.name) != Command.PROTECTIVE_STOP.value:
            self.closed.pop(station.name, None)
        self.states[run] = state

    def read_open_runs(self) -> None:
        """Learn of events of which no supervisor has heard; there is none at work."""
        for head in self.log.heads():
            known = self.states.get(head.number)
            if known is None or known.ended is None:
                self.states[head.number] = self.log.state(head.number)

    def on_event(
        self, station: Station, process: Process, run: int, event: Event, after: RunState
    ) -> None:
        if self.simulation.tracing:
            self.simulation.note(process.name, "run {}: {}", run, _short(event))
        allowed = Commanded | Answered | StopReported
        if process.noticed_leaving and not isinstance(event, allowed):
            self.simulation.violated(f"a shutdown left the event {event}")
        if isinstance(event, Answered | Escalated | RunEnded):
            self.stopped.pop(station.name, None)
        stop = self.stopped.get(station.name)
        if stop and code_of(event) in PERSON_FIRST:
            stop.is_kept = True
        if isinstance(event, TaskBegun) and event.part is Part.DISCARD:
            self._discards.add(event.task)
        elif isinstance(event, TaskBegun) and event.part is Part.WHOLE:
            self._discards.discard(event.task)
        before = self.states.get(run)
        is_new = before is None or before.stop != after.stop
        if is_new and after.stop.endswith("by another client of the engine"):
            if not station.engine.has_late_stop:
                self.simulation.violated(f"run {run}: {after.stop}, though no client did")
            station.engine.has_late_stop = False
        self.states[run] = after
        for name, task in after.tasks.items():
            was = before.tasks.get(name) if before else None
            if task is was or task.stage is not Stage.DONE:
                continue
            is_done_now = was is None or was.stage is not Stage.DONE
            if is_done_now and not self._is_placed(after, name):
                self.simulation.violated(f"run {run} calls {name} done, which is not placed")

    def on_end(self, station: Station, run: int, state: RunState) -> None:
        self.ended[run] = state
        if state.ended is None:
            self.simulation.violated(f"run {run} was left without an end")

    # --- the gate

    def on_resume(self, station: Station) -> None:
        """Note that motion is allowed again: an operator is about to resume.

        A run that was paused at one station may be resumed at another of the same cell.
        """
        for name, cell in self._closed_cells.items():
            if cell == station.cell:
                self.closed.pop(name, None)

    def on_reply(self, station: Station, event: Commanded, sent_s: float) -> None:
        """Check that nothing moves when a command was answered with success."""
        if event.command in _CLOSING:
            self.closed[station.name] = event.command.value
            self._closed_cells[station.name] = station.cell
            moving = [each for each in self.site.moving if each.station == station.name]
            if moving:
                self.simulation.violated(
                    f"{event.command.value} was answered while {moving[0].what} moves"
                )
        elif event.command is Command.SKIP:
            for each in self.site.moving:
                is_it = (each.station, each.wire) == (station.name, event.task)
                if is_it and each.begun_s < sent_s:
                    self.simulation.violated(f"skip was answered while {each.what} moves")

    def _on_motion(self, motion: Motion) -> None:
        why = self.closed.get(motion.station)
        if why:
            self.simulation.violated(f"{motion.what} begins although {why} was answered")
        stop = self.stopped.get(motion.station)
        if stop and not stop.is_lost:
            self.simulation.violated(f"{motion.what} begins although {stop.text} is unanswered")
        if not motion.owner:
            self.simulation.violated(f"{motion.what} begins without an owner")

    def _on_result(self, motion: Motion, code: int) -> None:
        if code in PERSON_FIRST - {Code.STALE_OWNER}:
            has_record = motion.begun_s > self._engine_died_s.get(motion.station, -1.0)
            text = f"{motion.what} ended with {code}"
            self.stopped[motion.station] = Stop(motion, text, has_record=has_record)

    def on_heard(self, motion: Motion, process: Process) -> None:
        """Note that a supervisor has heard the result of a motion."""
        stop = self.stopped.get(motion.station)
        if stop and stop.motion is motion:
            stop.heard_by = process

    def on_engine_death(self, station: Station) -> None:
        """Note that records that were not kept, and states that wait, are lost with the engine."""
        if stop := self.stopped.get(station.name):
            stop.has_record = False
        self._engine_died_s[station.name] = self.simulation.now_s

    # --- the world

    def _on_entry(self, entry: Entry) -> None:
        end = f"{entry.wire}/{entry.end}"
        match entry.deed:
            case Deed.LOAD:
                if self._fixed and entry.wire <= self._serial:
                    self.simulation.violated(
                        f"panel {entry.wire} was built again; fixed were {sorted(self._fixed)}"
                    )
                self._fixed, self._serial = set(), max(self._serial, entry.wire)
            case Deed.FIX:
                if end in self._fixed:
                    self.simulation.violated(f"{end} was fixed twice")
                self._fixed.add(end)
            case Deed.LOOSEN:
                self._require_not_done(entry)
                self._fixed.discard(end)
            case Deed.DISCARD:
                self._require_not_done(entry)
                self._require_on_purpose(entry)
                self._fixed -= {f"{entry.wire}/a", f"{entry.wire}/b"}

    def _require_not_done(self, entry: Entry) -> None:
        for run, state in self.states.items():
            task = state.tasks.get(entry.wire)
            if task and state.serial == self._serial and task.stage is Stage.DONE:
                self.simulation.violated(f"{entry.deed.value} of {entry.wire}, done in run {run}")

    def _require_on_purpose(self, entry: Entry) -> None:
        fixed = {f"{entry.wire}/a", f"{entry.wire}/b"} & self._fixed
        if len(fixed) == 2 and not self._is_misplaced(entry.wire):
            self.simulation.violated(f"{entry.wire} was discarded, though both ends were fixed")
        if entry.wire not in self._discards and not self._is_discard_kept(entry.wire):
            self.simulation.violated(f"{entry.wire} was discarded, though no run had decided so")

    def _is_misplaced(self, wire: str) -> bool:
        """Return whether a run remembers that a wire lies beside its ducts."""
        here = (state for state in self.states.values() if state.serial == self._serial)
        tasks = (state.tasks.get(wire) for state in here)
        return any(task is not None and task.misplaced for task in tasks)

    def _is_discard_kept(self, wire: str) -> bool:
        """Return whether the log has a discard whose commit was not answered."""
        tasks = (self.log.state(head.number).tasks.get(wire) for head in self.log.heads())
        return any(task is not None and task.part is Part.DISCARD for task in tasks)

    def _is_placed(self, state: RunState, name: str) -> bool:
        world = self.site.world
        return world.panel.serial == state.serial and world.is_placed(name)


def code_of(event: Event) -> int:
    """Return the error code that an event keeps; 0 without one."""
    if isinstance(event, OperationEnded | StopReported):
        return event.operation.error_code
    return event.code if isinstance(event, Settled) else 0


def _short(event: Event) -> str:
    text = str(event)
    return text if len(text) < 260 else f"{text[:260]}..."
