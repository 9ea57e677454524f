"""A ROS master with the nodes of a launch file and an order, ways to disturb them, and the runs."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import TypeVar
from xmlrpc.client import ServerProxy, Transport

import rosgraph

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_planner/test/rostest"))
from order_client import DESIGN, ORDER, planner, wait_until
from own_launch import free_port

from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import LostError
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.edge.run_rows import KeptEvent

# [s] wall time for what must happen; beyond it something hangs.
LIMIT_S = 90.0
# [s] wall time that a node gets to answer.
_ANSWER_S = 2.0

T = TypeVar("T")


@contextlib.contextmanager
def stack(
    launch: Path, output: Path, design: str = DESIGN, url: str = "", **arguments: object
) -> Iterator[Stack]:
    """Launch nodes below a master of their own, with an order in a database, and end them.

    Args:
        launch: the launch file; it takes `output` and `database`.
        output: folder of everything; made.
        design: file of the order.
        url: of the database; empty for a SQLite file in the folder.
        arguments: more of the launch file's.
    """
    (output / "charts").mkdir(parents=True)
    url = url or f"sqlite:///{output}/production.sqlite"
    port = free_port()
    os.environ |= {
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_LOG_DIR": str(output / "log"),
        "ROS_PACKAGE_PATH": f"{output}/remodel_order_behaviors:{os.environ['ROS_PACKAGE_PATH']}",
    }
    imported = planner("import", design, "--order", ORDER, database=url)
    assert imported.returncode == 0, imported.stderr
    given = {"output": output, "database": url, **arguments}
    line = ["roslaunch", str(launch), *(f"{name}:={value}" for name, value in given.items())]
    nodes = Stack(port, line, output, url)
    try:
        nodes.start_master()
        nodes.start_launch()
        yield nodes
    finally:
        nodes.end_launch()
        nodes.end_master()


class Stack:
    """Nodes that run, below a master of their own.

    Attributes:
        output: folder of everything.
        database: its URL.
    """

    def __init__(self, port: int, line: list[str], output: Path, database: str) -> None:
        self.output, self.database = output, database
        self._port, self._line = port, line
        self._master = rosgraph.Master("/bench")

    def start_master(self) -> None:
        """Start the ROS master, and return when it answers."""
        self._core = self._started(["roscore", "-p", str(self._port)], "master.log")
        wait_until(self._has_run_id, "start of the ROS master", LIMIT_S)

    def end_master(self, number: int = signal.SIGINT) -> None:
        """Send the ROS master a signal, and return when it has ended."""
        pids = (self.master_pid(), self.pid("rosout"))
        _end(self._core, number)
        if number == signal.SIGKILL:  # roscore cannot end what it has started
            for pid in filter(None, pids):
                os.kill(pid, signal.SIGKILL)
        wait_until(lambda: self.master_pid() == 0, "end of the ROS master", LIMIT_S)

    def start_launch(self) -> None:
        """Start all nodes."""
        self._nodes = self._started(self._line, "nodes.log")

    def end_launch(self) -> None:
        """End all nodes as Ctrl-C in the terminal of roslaunch does."""
        _end(self._nodes, signal.SIGINT)

    def wait_for(self, *nodes: str) -> None:
        """Return when nodes of these names answer."""
        for node in nodes:
            wait_until(lambda node=node: self.pid(node) > 0, f"start of {node}", LIMIT_S)
        assert self._nodes.poll() is None, f"roslaunch has ended; see {self.output}/nodes.log"

    def pid(self, node: str) -> int:
        """Return a node's process; 0 if it does not answer."""
        try:
            return _pid(self._master.lookupNode(f"/{node}"))
        except (OSError, rosgraph.MasterError):
            return 0

    def master_pid(self) -> int:
        """Return the process of the ROS master; 0 if it does not answer."""
        return _pid(os.environ["ROS_MASTER_URI"])

    def kill(self, *nodes: str, number: int = signal.SIGKILL) -> None:
        """Send nodes a signal that ends them, and return when others answer in their place."""
        before = {node: self.pid(node) for node in nodes}
        for pid in filter(None, before.values()):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)
        for node, pid in before.items():
            wait_until(lambda n=node, p=pid: self.pid(n) not in (0, p), f"{node} back", LIMIT_S)

    def _started(self, line: list[str], log: str) -> subprocess.Popen[bytes]:
        with (self.output / log).open("a") as file:
            return subprocess.Popen(
                line, stdout=file, stderr=subprocess.STDOUT, start_new_session=True
            )

    def _has_run_id(self) -> bool:
        try:
            return bool(self._master.hasParam("/run_id"))
        except (OSError, rosgraph.MasterError):
            return False


def _end(process: subprocess.Popen[bytes], number: int) -> None:
    process.send_signal(number)
    try:
        process.wait(LIMIT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _pid(uri: str) -> int:
    """Return the process that serves ROS at an address; 0 if none answers."""
    try:
        return int(ServerProxy(uri, _ImpatientTransport()).getPid("/bench")[2])
    except OSError:
        return 0


class _ImpatientTransport(Transport):
    """Does not wait forever for what was stopped."""

    def make_connection(self, host: str) -> HTTPConnection:  # type: ignore[override]
        connection = super().make_connection(host)  # type: ignore[arg-type]
        connection.timeout = _ANSWER_S
        return connection


class Runs:
    """What the production database has of runs, once it answers."""

    def __init__(self, url: str) -> None:
        self._log = RunLog(ProductionDatabase(url))

    def newest(self) -> int:
        """Return the number of the newest run; 0 without any."""
        return max((head.number for head in _insist(self._log.heads)), default=0)

    def has_ended(self, run: int) -> bool:
        """Return whether a run has ended."""
        return next(head.ended for head in _insist(self._log.heads) if head.number == run)

    def state(self, run: int) -> RunState:
        """Return what is known of a run."""
        return _insist(lambda: self._log.state(run))

    def events(self, run: int, since: int = 0) -> list[KeptEvent]:
        """Return what happened in a run since a position."""
        return _insist(lambda: list(self._log.events(run, since)))


def _insist(ask: Callable[[], T]) -> T:
    end = time.monotonic() + LIMIT_S
    while True:
        try:
            return ask()
        except LostError:
            if time.monotonic() > end:
                raise
            time.sleep(0.1)
