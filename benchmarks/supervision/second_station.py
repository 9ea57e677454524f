"""A second station that claims the same cell: a ROS master and a supervisor of its own."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

from stack import ORDER, Program, TroubleError, free_port, wait_until

_LIMIT_S = 60.0
_REFUSAL = "is owned by another station"


class SecondStation:
    """Runs beside the first; whatever it does to the cell is a violation."""

    def __init__(self, folder: Path, database: str) -> None:
        """Prepare it.

        Args:
            folder: of its logs; made.
            database: URL of the first station's database.
        """
        folder.mkdir(parents=True)
        self._database = database
        self._log = folder / "supervisor.log"
        port = str(free_port())
        self._environment = {
            **os.environ,
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_LOG_DIR": str(folder),
        }
        environment = self._environment
        self._master = Program(["roscore", "-p", port], folder / "master.log", environment)
        line = ["rosrun", "remodel_planner", "use_case_supervisor", "--unattended"]
        line += ["--database", database, "--output", str(folder)]
        self._supervisor = Program(line, self._log, environment)

    def start(self) -> None:
        """Start it, and return when it has been refused the cell; TroubleError if it is not."""
        self._master.start()
        self._supervisor.start()
        wait_until(lambda: _REFUSAL in self._log.read_text(), _LIMIT_S, "refusal of a station")

    def order(self) -> None:
        """Order something of it; TroubleError unless that is refused in words."""
        line = ["remodel", "run", ORDER, "--wires", "2"]
        line += ["--database", self._database, "--output", str(self._log.parent)]
        ordered = subprocess.run(
            line,
            env=self._environment,
            capture_output=True,
            text=True,
            timeout=_LIMIT_S,
            check=False,
        )
        if ordered.returncode != 3 or _REFUSAL not in ordered.stderr:
            raise TroubleError(f"the second station takes an order: {ordered}")

    def end(self) -> None:
        """End it; TroubleError if it ever resumed a run."""
        self._supervisor.end(signal.SIGINT)
        self._master.end(signal.SIGINT)
        if "resuming run" in self._log.read_text():
            raise TroubleError(f"the second station resumed a run; see {self._log}")
