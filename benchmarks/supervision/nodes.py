"""Start a launch file on a ROS master of its own, and end all that it has started."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# [s] wall time that roslaunch gets to end its nodes; it kills them after 15 s itself.
_STOP_LIMIT_S = 40.0


@contextmanager
def launched(launch_file: Path, arguments: dict[str, str], output: Path) -> Iterator[None]:
    """Have the nodes of a launch file run meanwhile, and this process use their master.

    Args:
        launch_file: to start.
        arguments: of the launch file.
        output: folder of the logs, and of the behaviors that are synthesized.
    """
    port = _free_port()
    os.environ |= {
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_LOG_DIR": str(output / "log"),
        "ROS_PACKAGE_PATH": f"{output}/remodel_order_behaviors:{os.environ['ROS_PACKAGE_PATH']}",
    }
    words = [f"{name}:={value}" for name, value in arguments.items()]
    with (output / "nodes.log").open("w") as log:
        nodes = subprocess.Popen(
            ["roslaunch", "-p", str(port), str(launch_file), *words],
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            yield
        finally:
            nodes.send_signal(signal.SIGINT)
            try:
                nodes.wait(_STOP_LIMIT_S)
            except subprocess.TimeoutExpired:
                os.killpg(nodes.pid, signal.SIGKILL)
                nodes.wait()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
