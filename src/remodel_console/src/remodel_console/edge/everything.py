"""Everything but the console, started on this computer by one button."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from pathlib import Path
from typing import BinaryIO

from remodel_console.edge.order_desk.planner_process import DATABASE_VARIABLE, PlannerProcess
from remodel_console.errors import CommandError

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
