"""A ROS master of its own with the nodes of a launch file, an order, and a way to kill nodes."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from xmlrpc.client import ServerProxy

import rosgraph

ORDER = "house"
DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
_LOOK_S = 0.02
_START_LIMIT_S = 90.0


class TroubleError(Exception):
    """The stack does not do what it must; the text says what."""


def free_port() -> int:
    """Return a port that nobody listens on."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def wait_until(holds: Callable[[], bool], limit_s: float, what: str) -> None:
    """Return when something holds; TroubleError if it does not within a wall time [s]."""
    end = time.monotonic() + limit_s
    while not holds():
        if time.monotonic() > end:
            raise TroubleError(f"{what}: not within {limit_s:.0f} s")
        time.sleep(_LOOK_S)


@contextlib.contextmanager
def stack(launch: Path, output: Path, design: str = DESIGN, **arguments: object) -> Iterator[Stack]:
    """Launch nodes below a master of their own, with an order in a database, and end them.

    Args:
        launch: the launch file; it takes `output` and `database`.
        output: folder of everything; made.
        design: file of the order.
        arguments: more of the launch file's.
    """
    (output / "charts").mkdir(parents=True)
    port = free_port()
    url = f"sqlite:///{output}/production.sqlite"
    os.environ |= {
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_LOG_DIR": str(output / "log"),
        "REMODEL_DATABASE": url,
        "ROS_PACKAGE_PATH": f"{output}/remodel_order_behaviors:{os.environ['ROS_PACKAGE_PATH']}",
    }
    subprocess.run(
        ["rosrun", "remodel_planner", "import", design, "--order", ORDER],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    arguments = {"output": output, "database": url, **arguments}
    given = [f"{name}:={value}" for name, value in arguments.items()]
    with (output / "nodes.log").open("w") as log:
        nodes = subprocess.Popen(
            ["roslaunch", "-p", str(port), str(launch), *given],
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        try:
            yield Stack(nodes, output, url)
        finally:
            nodes.send_signal(signal.SIGINT)
            try:
                nodes.wait(60.0)
            except subprocess.TimeoutExpired:
                nodes.kill()
                nodes.wait()


class Stack:
    """Nodes that run.

    Attributes:
        output: folder of everything.
        database: its URL.
    """

    def __init__(self, nodes: subprocess.Popen[bytes], output: Path, database: str) -> None:
        """Take the launch that runs them."""
        self._nodes = nodes
        self.output = output
        self.database = database
        self._master = rosgraph.Master("/bench")

    def require(self) -> None:
        """Return if the launch runs; TroubleError if it has ended."""
        if self._nodes.poll() is not None:
            raise TroubleError(f"roslaunch has ended; see {self.output}/nodes.log")

    def wait_for(self, *nodes: str) -> None:
        """Return when nodes of these names answer."""
        for node in nodes:
            wait_until(lambda node=node: self.pid(node) > 0, _START_LIMIT_S, f"start of {node}")
            self.require()

    def pid(self, node: str) -> int:
        """Return a node's process; 0 if it does not answer."""
        try:
            uri = self._master.lookupNode(f"/{node}")
            return int(ServerProxy(uri).getPid("/bench")[2])
        except (OSError, rosgraph.MasterError):
            return 0

    def kill(self, *nodes: str) -> dict[str, int]:
        """Kill nodes, and return the processes that they were."""
        pids = {node: self.pid(node) for node in nodes}
        for pid in pids.values():
            if pid:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
        return pids
