"""The live system as the console knows it now; written by any thread, read by all."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from remodel_console.core.run.decision import Decisions
from remodel_console.core.run.log_line import LogLine
from remodel_console.core.run.run_view import Event, Troubled, step
from remodel_console.core.use_case.use_case import UseCase
from remodel_console.core.world import (
    CellKind,
    InputRequest,
    Part,
    World,
    with_supervisor,
    with_use_case,
)
from remodel_run.progress import HandWire

_TROUBLE = ("warning", "error")
_KEPT_LINES = 500  # of the log; a page that opens shows them


class LogKeeper(Protocol):
    """Keeps the log for the next start."""

    @property
    def lines(self) -> tuple[LogLine, ...]:
        """Return the last lines."""

    def all_lines(self) -> tuple[LogLine, ...]:
        """Return all lines that are kept."""

    def write(self, line: LogLine) -> None:
        """Keep a line."""


class Live:
    """Holds the newest world and the last lines of the log.

    Attributes:
        on_hand_wires: gets the wires by hand of a product, by its serial number, as they arrive.
    """

    def __init__(
        self, log: LogKeeper | None = None, clock: Callable[[], float] = time.time
    ) -> None:
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
        with self._lock:
            self._world = replace(self._world, has_master=is_there)
        self._wake()

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
        with self._lock:
            self._world = replace(self._world, inputs=inputs)
        self._wake()

    def set_decisions(self, decisions: Decisions) -> None:
        """Set what an operator can decide in the running behavior."""
        with self._lock:
            self._world = replace(self._world, decisions=decisions)
        self._wake()

    def set_breakpoints(self, paths: frozenset[str]) -> None:
        """Set the states before whose end the engine asks."""
        if paths == self._world.breakpoints:
            return
        with self._lock:
            self._world = replace(self._world, breakpoints=paths)
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
