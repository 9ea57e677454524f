"""The planner's commands, each in a process of its own: a large design never holds up the pages."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from remodel_console.errors import CommandError

# The planner yields to the cell, which may be working on the same computer.
_COMMAND = ("nice", "-n", "10", "remodel")
LIMIT_S = 900.0  # of wall time; the largest harnesses take a minute
_STAGE = "stage "  # what a line on the standard error begins with that says what a command does
DATABASE_VARIABLE = "REMODEL_DATABASE"  # other users see a command line, but no environment


@dataclass(frozen=True)
class Finished:
    """How a command has ended, and what it printed."""

    code: int
    printed: str
    error: str


class PlannerProcess:
    """Runs commands; several threads may."""

    def __init__(self, command: Sequence[str] = _COMMAND) -> None:
        """Begin with none running; `command` is the planner's, which takes their words."""
        self._command = command
        self._running: dict[subprocess.Popen[str], Path] = {}
        self._lock = threading.Lock()
        self._has_ended = False

    def run(
        self,
        words: Sequence[str],
        folder: Path,
        database: str,
        report: Callable[[str], None] = lambda stage: None,
        limit_s: float = LIMIT_S,
    ) -> Finished:
        """Run a command in a folder, and return how it ended.

        Args:
            words: of its command line, after `planner`.
            folder: that it runs in, and that the names of files in its messages are relative to.
            database: URL of the production database that it works with.
            report: called with each stage that the command begins, such as `2/4: planning`.
            limit_s: [s] wall time after which it is ended.

        Raises:
            CommandError: if it cannot be started, takes too long, or is ended.
        """
        environment = os.environ | {DATABASE_VARIABLE: database}
        with self._lock:
            if self._has_ended:
                raise CommandError("the console is ending")
            try:
                process = subprocess.Popen(
                    [*self._command, *words],
                    cwd=folder,
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                    text=True,
                    start_new_session=True,
                )
            except OSError as error:
                raise CommandError(f"the planner cannot be started: {error}") from error
            self._running[process] = folder
        errors: list[str] = []
        is_late = threading.Event()

        def end_late() -> None:
            is_late.set()
            _end(process)

        limit = threading.Timer(limit_s, end_late)
        limit.start()
        reader = threading.Thread(target=_read, args=(process.stderr, report, errors.append))
        reader.start()
        try:
            with process:
                printed = process.stdout.read() if process.stdout else ""
                reader.join()
        finally:
            limit.cancel()
            with self._lock:
                self._running.pop(process)
        if is_late.is_set():
            raise CommandError(f"the planner has not finished within {limit_s:.0f} s")
        if process.returncode < 0 or process.returncode == 128 + signal.SIGTERM:
            raise CommandError(f"`remodel {words[0]}` was ended")
        return Finished(process.returncode, printed, "".join(errors).strip())

    def end_in(self, folder: Path) -> None:
        """End the commands that run in a folder."""
        with self._lock:
            for process, where in self._running.items():
                if where == folder:
                    _end(process)

    def end(self) -> None:
        """End all commands, for good."""
        with self._lock:
            self._has_ended = True
            for process in self._running:
                _end(process)


def _read(
    lines: Iterable[str] | None, report: Callable[[str], None], keep: Callable[[str], None]
) -> None:
    """Report the stages of a command, and keep its other lines."""
    for line in lines or ():
        if line.startswith(_STAGE):
            report(line.removeprefix(_STAGE).rstrip())
        else:
            keep(line)


def _end(process: subprocess.Popen[str]) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
