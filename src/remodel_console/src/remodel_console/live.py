"""The live system as the console knows it now, and commands of pages for what runs."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from remodel_console.core.commands import DONE, FAILED, REFUSED, Actor, CommandResult, Role
from remodel_console.core.run_view import EngineSeen, Event, Ordered, Phase, Troubled, step
from remodel_console.core.running import (
    Attach,
    Decisions,
    LogLine,
    Order,
    SetAutonomy,
    SimpleOrder,
    Start,
    Switch,
    TakeOutcome,
)
from remodel_console.core.use_case import UseCase
from remodel_console.core.world import (
    CellKind,
    InputRequest,
    Part,
    World,
    with_supervisor,
    with_use_case,
)
from remodel_console.edge.kept_files import Journal, LogFile
from remodel_console.edge.workspace import Catalogue
from remodel_console.errors import CommandError, expect_ros
from remodel_console.session import Session
from remodel_run.progress import HandWire

_TROUBLE = ("warning", "error")
_KEPT_LINES = 500  # of the log; a page that opens shows them


class Live:
    """Holds the newest world and the last lines of the log.

    Attributes:
        on_hand_wires: gets the wires by hand of a product, by its serial number, as they arrive.
    """

    def __init__(self, log: LogFile | None = None, clock: Callable[[], float] = time.time) -> None:
        """Begin with nothing there but the lines of a log that was kept; `clock`: wall time [s]."""
        self._clock = clock
        self._lock = threading.Lock()
        self._world = World()
        self._log = log
        self._lines: deque[LogLine] = deque(log.lines if log else (), maxlen=_KEPT_LINES)
        self._line_count = len(self._lines)
        self._wake: Callable[[], None] = lambda: None
        self.on_hand_wires: Callable[[str, tuple[HandWire, ...]], None] = lambda *_: None

    @property
    def world(self) -> World:
        """Return what is there now."""
        return self._world

    def on_change(self, wake: Callable[[], None]) -> None:
        """Have a function called, on any thread, after each change."""
        self._wake = wake

    def refresh(self) -> None:
        """Have all pages shown again, for what is not part of the world."""
        self._wake()

    def take(self, event: Event) -> None:
        """Take in an event of the engine."""
        with self._lock:
            self._world = replace(self._world, run=step(self._world.run, event))
        self._wake()

    def take_line(self, line: LogLine) -> None:
        """Take in a line of the log."""
        with self._lock:
            self._lines.append(line)
            self._line_count += 1
            if line.severity in _TROUBLE:
                self._world = replace(self._world, run=step(self._world.run, Troubled(line.text)))
        if self._log is not None:
            self._log.write(line)
        self._wake()

    def set_master(self, is_there: bool) -> None:
        """Set whether ROS is running."""
        self._change(has_master=is_there)

    def set_presence(
        self,
        *,
        mirror: bool,
        servers: int,
        cell_kind: CellKind | None,
        can_reset: bool = False,
        supervisor: bool,
        silent: frozenset[Part] = frozenset(),
    ) -> None:
        """Set which nodes are running; the state of a supervisor that has ended is out of date."""
        with self._lock:
            before = self._world
            seen = replace(
                before,
                has_mirror=mirror,
                servers=servers,
                cell_kind=cell_kind,
                can_reset=can_reset,
                has_supervisor=supervisor,
                silent=silent,
            )
            answers = supervisor and Part.SUPERVISOR not in silent
            self._world = with_supervisor(seen, answers=answers, now_s=self._clock())
        if self._world != before:
            self._wake()

    def take_use_case(self, use_case: UseCase) -> None:
        """Take in the state of the use case supervisor."""
        if use_case.serial and use_case.by_hand:
            self.on_hand_wires(use_case.serial, use_case.by_hand)
        with self._lock:
            self._world = with_use_case(self._world, use_case, self._clock())
        self._wake()

    def set_inputs(self, inputs: tuple[InputRequest, ...]) -> None:
        """Set the values that states wait for."""
        self._change(inputs=inputs)

    def set_decisions(self, decisions: Decisions) -> None:
        """Set what an operator can decide in the running behavior."""
        self._change(decisions=decisions)

    def set_breakpoints(self, paths: frozenset[str]) -> None:
        """Set the states before whose end the engine asks."""
        if paths != self._world.breakpoints:
            self._change(breakpoints=paths)

    def _change(self, **changed: object) -> None:
        with self._lock:
            self._world = replace(self._world, **changed)  # type: ignore[arg-type]
        self._wake()

    def exported_log(self) -> str:
        """Return the log as a text file: all that is kept of it, of runs before, too."""
        lines = self._log.all_lines() if self._log is not None else tuple(self._lines)
        return "".join(map(_exported, lines))

    def lines_since(self, count: int) -> tuple[tuple[LogLine, ...], int]:
        """Return the lines that came after the first `count`, and how many there are by now."""
        with self._lock:
            new = min(self._line_count - count, len(self._lines))
            lines = tuple(self._lines)[len(self._lines) - new :] if new else ()
            return lines, self._line_count


def _exported(line: LogLine) -> str:
    """Return a line of a text file, with the local date and time."""
    at = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(line.time_s))
    return f"{at}  {line.severity:7}  {line.text}\n"


_A = {Role.WATCHER: "a watcher", Role.OPERATOR: "an operator", Role.ENGINEER: "an engineer"}
_LOG = logging.getLogger(__name__)


class Desk:
    """Executes the commands of all pages."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal

    def give(
        self,
        actor: Actor,
        command: str,
        deed: Callable[[], str | None],
        needs: Role = Role.OPERATOR,
    ) -> CommandResult:
        """Execute a command, record it, and return the answer.

        Args:
            actor: who gives it.
            command: what it is, for the record.
            deed: does it, and returns the answer in words.
            needs: the role that the command needs.
        """
        if actor.role.may(needs):
            answer = answer_of(command, deed, _LOG.error)
        else:
            words = f"{actor.name} is {_A[actor.role]}; this needs {_A[needs]}"
            answer = CommandResult(REFUSED, command, words)
        self.record(actor, answer)
        return answer

    def record(self, actor: Actor, answer: CommandResult) -> None:
        """Record a command that was carried out elsewhere, such as signing in."""
        self._journal.write(actor, answer)


def answer_of(
    command: str, deed: Callable[[], str | None], log_error: Callable[..., object]
) -> CommandResult:
    """Execute a command and return the answer; a defect is logged with its trace."""
    try:
        return CommandResult(DONE, command, deed() or "")
    except CommandError as error:
        return CommandResult(FAILED, command, str(error))
    except Exception as error:  # noqa: BLE001 - an answer must come, whatever is wrong
        log_error("the command '%s' failed", command, exc_info=True)
        return CommandResult(FAILED, command, f"internal error: {error!r}; the log has the trace")


class Engine(Protocol):
    """Commands to the engine."""

    def send(self, order: Order) -> None:
        """Send an order."""

    def userdata(self) -> tuple[tuple[str, str, str, str], ...]:
        """Return (where, key, type, value) of the userdata of what runs."""

    def set_breakpoints(self, paths: frozenset[str]) -> None:
        """Set the states before whose end the engine asks."""


class Steering:
    """Steers what runs, for pages and commands alike.

    Attributes:
        engine: None until ROS is there.
    """

    def __init__(self, live: Live, session: Session, catalogue: Catalogue) -> None:
        self.live = live
        self.session = session
        self.catalogue = catalogue
        self.engine: Engine | None = None
        self._names: dict[int, str] = {}  # of behaviors, by the checksums of their sources
        self._unknown = 0  # checksum of what runs, once nothing installed was found to have it
        self._structure_asked = self._joined = 0  # checksums of what that was requested for
        self._is_heard = False

    def take(self, event: Event) -> None:
        """Take in an event of the engine, and request what is not known of a supervised behavior.

        A run that was supervised before this console knew it is attached to at its own level, so
        that the engine repeats what it asks.
        """
        self.live.take(event)
        if isinstance(event, EngineSeen):
            self._is_heard = event.is_there
        run = self.live.world.run
        if not run.is_supervised or run.level is None:
            self._structure_asked = self._joined = 0
            return
        if not self._is_heard:  # what is latched arrives before the engine can be commanded
            return
        with contextlib.suppress(CommandError):  # it has ended meanwhile
            if run.ordered.level is None and self._joined != run.behavior_id:
                self.order(Attach(run.level))
            self._joined = run.behavior_id
            if not run.has_structure and self._structure_asked != run.behavior_id:
                self.order(SimpleOrder.SHOW_STRUCTURE)
                self._structure_asked = run.behavior_id

    def order(self, order: Order) -> None:
        """Send an order to the engine.

        Raises:
            CommandError: if it cannot be sent.
        """
        engine = expect_ros(self.engine)
        if isinstance(order, Start | Switch):
            self.live.take(Ordered(order.level, order.source_checksum))
        elif isinstance(order, Attach | SetAutonomy):
            self.live.take(Ordered(order.level))
        elif isinstance(order, TakeOutcome):
            label = order.path.rpartition("/")[2]
            asking = [a for a in self.live.world.run.asks if a.path.rpartition("/")[2] == label]
            order = replace(order, is_by_path=len(asking) > 1)
        try:
            engine.send(order)
        except CommandError:
            if isinstance(order, Start):
                self.live.take(Ordered(None))  # nothing starts
            raise

    def change_breakpoints(
        self, *, added: frozenset[str] = frozenset(), removed: frozenset[str] = frozenset()
    ) -> None:
        """Have the engine ask before it leaves states, or no longer.

        Raises:
            CommandError: if ROS is not running.
        """
        paths = (self.live.world.breakpoints - removed) | added
        expect_ros(self.engine).set_breakpoints(paths)
        self.live.set_breakpoints(paths)

    def attach(self, level: int) -> None:
        """Supervise the running behavior.

        Raises:
            CommandError: if another behavior is loaded, or nothing runs.
        """
        run = self.live.world.run
        if run.phase is not Phase.RUNNING:
            raise CommandError("no behavior runs")
        name, chart = self.running_name(), self.session.chart
        loaded = f"'{chart.name}'" if chart else "nothing"
        if name and (chart is None or chart.name != name):
            raise CommandError(f"'{name}' is running, and {loaded} is loaded; load '{name}' first")
        self.order(Attach(level))

    def newer_version(self) -> Switch | None:
        """Return the switch to the saved version of the supervised behavior, if it differs."""
        run = self.live.world.run
        if not run.is_supervised or run.level is None:
            return None
        name = self.running_name()
        found = next((one for one in self.catalogue.behaviors() if one.name == name), None)
        if found is None or found.source_checksum == run.behavior_id:
            return None
        return Switch(name, found.behavior_id, found.source_checksum, run.level)

    def version_to_switch_to(self) -> Switch:
        """Return the switch to the saved version of the supervised behavior.

        Raises:
            CommandError: if no version differs, or this console supervises no behavior.
        """
        if not self.live.world.run.is_supervised:
            raise CommandError("this console supervises no running behavior; attach to one first")
        version = self.newer_version()
        if version is None:
            raise CommandError("the saved version is running already; 'save' saves another one")
        return version

    def running_name(self) -> str:
        """Return the display name of what runs; empty if its version is not installed here."""
        run = self.live.world.run
        if run.attached_name:
            return run.attached_name
        if run.behavior_id not in (self._unknown, *self._names):
            self._names |= {one.source_checksum: one.name for one in self.catalogue.behaviors()}
            self._unknown = 0 if run.behavior_id in self._names else run.behavior_id
        return self._names.get(run.behavior_id, "")
