"""Processes that the console starts: the planner's commands, and everything else by one button."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from remodel_console.errors import CommandError

# The planner yields to the cell, which may be working on the same computer: beside a process that
# keeps a core busy it gets a quarter of that core, and a person waits for what it plans.
_COMMAND = ("nice", "-n", "5", "remodel")
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


SAMPLE = "sample"
_DESIGN = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")
_LAUNCH = ("roslaunch", "remodel_planner", "everything.launch")
_END_S = 60.0  # wall time in which roslaunch ends its nodes: 15 s until it insists, and again
_SHOWN_LINES = 5  # of the log, when the nodes have ended by themselves


class Everything:
    """Engine, supervisor, cell and what operators' interfaces need, in processes of this console.

    They end with it. Database, behaviors and log of each kind of cell are in a folder of its own:
    a run that was interrupted goes on in the cell that it began in, and none of a production
    database ever goes on here.

    Attributes:
        folder: of what was started last.
        was_ended: the nodes that were started here last were ended here, too.
    """

    def __init__(self, folder: Path, planner: PlannerProcess) -> None:
        """Begin with nothing running; `folder` holds those of the cells."""
        self._cells = folder
        self.folder = folder
        self.was_ended = False
        self._planner = planner
        self._nodes: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    @property
    def database(self) -> str:
        """Return the URL of the production database of what was started last."""
        return f"sqlite:///{self.folder}/production.sqlite"

    @property
    def log(self) -> Path:
        """Return the file with what the nodes print that were started last."""
        return self.folder / "nodes.log"

    @property
    def is_running(self) -> bool:
        """Return whether the nodes were started here and run."""
        return self._nodes is not None and self._nodes.poll() is None

    @property
    def trouble(self) -> str:
        """Return the end of the log of nodes that ended by themselves; empty otherwise."""
        if self._nodes is None or self._nodes.poll() is None:
            return ""
        try:
            lines = self.log.read_text(errors="replace").splitlines()
        except OSError as error:
            return str(error)
        return "\n".join(lines[-_SHOWN_LINES:])

    def start(self, *, fake: bool, interfaces: bool) -> str:
        """Import the sample order, unless it is there, and start the nodes; return its name.

        Args:
            fake: with the cell that has no physics.
            interfaces: with what operators' interfaces need.

        Raises:
            CommandError: if the order cannot be imported, or the nodes cannot be started.
        """
        with self._lock:
            if self.is_running:
                raise CommandError("they have been started already")
            self.folder = self._cells / ("fake" if fake else "simulated")
            try:
                (self.folder / "charts").mkdir(parents=True, exist_ok=True)
                log = self.log.open("wb")
            except OSError as error:
                raise CommandError(f"cannot write to {self.folder}: {error}") from error
            with log:
                self._import()
                self._nodes = self._launch(log, fake=fake, interfaces=interfaces)
            self.was_ended = False
        return SAMPLE

    def stop(self) -> None:
        """End the nodes that were started here, and return when they have ended."""
        with self._lock:
            if self._nodes is not None and self._nodes.poll() is None:
                self.was_ended = True
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(self._nodes.pid, signal.SIGINT)
                try:
                    self._nodes.wait(_END_S)
                except subprocess.TimeoutExpired:
                    os.killpg(self._nodes.pid, signal.SIGKILL)
                    self._nodes.wait()
            self._nodes = None

    def _launch(self, log: BinaryIO, *, fake: bool, interfaces: bool) -> subprocess.Popen[bytes]:
        packages = f"{self.folder}/remodel_order_behaviors:{os.environ['ROS_PACKAGE_PATH']}"
        named = {
            "output": self.folder,
            "database": self.database,
            "fake": str(fake).lower(),
            "interfaces": str(interfaces).lower(),
        }
        try:
            return subprocess.Popen(
                [*_LAUNCH, *(f"{name}:={value}" for name, value in named.items())],
                env=os.environ | {"ROS_PACKAGE_PATH": packages, DATABASE_VARIABLE: self.database},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        except OSError as error:
            raise CommandError(f"roslaunch cannot be started: {error}") from error

    def _import(self) -> None:
        if not _DESIGN.exists():
            raise CommandError(
                f"the sample design {_DESIGN} is not installed: qelectrotech-examples"
            )
        known = self._planner.run(["tasks", "--order", SAMPLE], self.folder, self.database)
        if known.code == 0:
            return
        done = self._planner.run(
            ["import", str(_DESIGN), "--order", SAMPLE], self.folder, self.database
        )
        if done.code:
            raise CommandError(f"the sample order cannot be imported: {done.error}")
