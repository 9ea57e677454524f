"""A ROS master with the nodes of a launch file, an order, and ways to disturb the nodes.

And the rows of a table in the docs, written as lines of JSON; see tools/figure_tables.py.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator, Mapping
from http.client import HTTPConnection
from pathlib import Path
from xmlrpc.client import ServerProxy, Transport

import rosgraph

ORDER = "house"
DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
_CHECK_S = 0.02
_START_LIMIT_S = 90.0

# [s] wall time that a node gets to answer, and that roslaunch and roscore get to end.
_ANSWER_LIMIT_S = 2.0
_END_LIMIT_S = 60.0


class TroubleError(Exception):
    """The stack does not do what it must; the text says what."""


def free_port() -> int:
    """Return a free port."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def wait_until(holds: Callable[[], bool], limit_s: float, what: str) -> None:
    """Return when something holds; TroubleError if it does not within a wall time [s]."""
    end = time.monotonic() + limit_s
    while not holds():
        if time.monotonic() > end:
            raise TroubleError(f"{what}: not within {limit_s:.0f} s")
        time.sleep(_CHECK_S)


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
        "REMODEL_DATABASE": url,
        "ROS_PACKAGE_PATH": f"{output}/remodel_order_behaviors:{os.environ['ROS_PACKAGE_PATH']}",
    }
    subprocess.run(
        ["remodel", "import", design, "--order", ORDER],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    arguments = {"output": output, "database": url, **arguments}
    given = [f"{name}:={value}" for name, value in arguments.items()]
    nodes = Stack(port, [str(launch), *given], output, url)
    try:
        nodes.start_master()
        nodes.start_launch()
        yield nodes
    finally:
        nodes.end_launch()
        nodes.end_master()


class Program:
    """A program that is started and ended, again and again, and logs to a file."""

    def __init__(
        self, line: list[str], log: Path, environment: dict[str, str] | None = None
    ) -> None:
        self._line = line
        self._log = log
        self._environment = environment
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def runs(self) -> bool:
        """Whether it was started and has not ended."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start it."""
        with self._log.open("a") as log:
            self._process = subprocess.Popen(
                self._line,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=self._environment,
                start_new_session=True,
            )

    def end(self, number: int = signal.SIGINT) -> None:
        """Send it a signal, and return when it has ended."""
        if self._process is None:
            return
        self._process.send_signal(number)
        try:
            self._process.wait(_END_LIMIT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class Stack:
    """Nodes that run, below a master of their own.

    Attributes:
        output: folder of everything.
        database: its URL.
    """

    def __init__(self, port: int, arguments: list[str], output: Path, database: str) -> None:
        self.output = output
        self.database = database
        self._master = rosgraph.Master("/bench")
        self._core = Program(["roscore", "-p", str(port)], output / "master.log")
        self._nodes = Program(["roslaunch", *arguments], output / "nodes.log")

    def start_master(self) -> None:
        """Start the ROS master, and return when it answers."""
        self._core.start()
        wait_until(self._has_run_id, _START_LIMIT_S, "start of the ROS master")

    def end_master(self, number: int = signal.SIGINT) -> None:
        """Send the ROS master a signal, and return when it has ended."""
        pids = (self.master_pid(), self.pid("rosout"))
        self._core.end(number)
        if number == signal.SIGKILL:  # roscore cannot end what it has started
            for pid in filter(None, pids):
                os.kill(pid, signal.SIGKILL)
        wait_until(lambda: self.master_pid() == 0, _END_LIMIT_S, "end of the ROS master")

    def start_launch(self) -> None:
        """Start all nodes."""
        self._nodes.start()

    def end_launch(self) -> None:
        """End all nodes as Ctrl-C in the terminal of roslaunch does."""
        self._nodes.end(signal.SIGINT)

    def require(self) -> None:
        """Return if the launch runs; TroubleError if it has ended."""
        if not self._nodes.runs:
            raise TroubleError(f"roslaunch has ended; see {self.output}/nodes.log")

    def wait_for(self, *nodes: str) -> None:
        """Return when nodes of these names answer."""
        for node in nodes:
            wait_until(lambda node=node: self.pid(node) > 0, _START_LIMIT_S, f"start of {node}")
            self.require()

    def pid(self, node: str) -> int:
        """Return a node's process; 0 if it does not answer."""
        try:
            return _pid(self._master.lookupNode(f"/{node}"))
        except (OSError, rosgraph.MasterError):
            return 0

    def master_pid(self) -> int:
        """Return the process of the ROS master; 0 if it does not answer."""
        return _pid(os.environ["ROS_MASTER_URI"])

    def kill(self, *nodes: str, number: int = signal.SIGKILL) -> dict[str, int]:
        """Send nodes a signal, and return the processes that they were."""
        pids = {node: self.pid(node) for node in nodes}
        for pid in pids.values():
            if pid:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, number)
        return pids

    def wait_for_others(self, pids: dict[str, int], limit_s: float) -> None:
        """Return when nodes answer from other processes than these."""
        for node, pid in pids.items():
            wait_until(lambda n=node, p=pid: self.pid(n) not in (0, p), limit_s, f"{node} back")

    def _has_run_id(self) -> bool:
        try:
            return bool(self._master.hasParam("/run_id"))
        except (OSError, rosgraph.MasterError):
            return False


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
        connection.timeout = _ANSWER_LIMIT_S
        return connection


def add_figures_option(parser: ArgumentParser) -> None:
    """Add the option that names the file of a table in the docs."""
    text = "also write the rows of the docs' table there, such as docs/figures/NAME.jsonl"
    parser.add_argument("--figures", type=Path, metavar="FILE", help=text)


def write_figures(file: Path | None, rows: Iterable[Mapping[str, object]]) -> None:
    """Write the rows, unless there is no file."""
    if file is not None:
        file.write_text("".join(f"{json.dumps(row)}\n" for row in rows), encoding="utf-8")


def replace_row(file: Path | None, row: Mapping[str, object]) -> None:
    """Add a row, or replace the one with the same value in the first column."""
    if file is None:
        return
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    column = next(iter(row))
    rows = {found[column]: found for found in map(json.loads, lines)}
    write_figures(file, {**rows, row[column]: row}.values())
