"""A launch on a ROS master of its own, which a test starts and interrupts as a person would."""

import os
import signal
import socket
import subprocess

from order_client import ORDER, wait_until


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class OwnLaunch:
    """The nodes of a launch file below a master of their own, and commands that join them.

    Attributes:
        master: URI of the master.
    """

    def __init__(self, file, folder, **arguments):
        """Start the nodes; they log to the folder."""
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        port = free_port()
        self.master = f"http://127.0.0.1:{port}"
        self._environment = os.environ | {
            "ROS_MASTER_URI": self.master,
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": str(folder / "log"),
            "ROS_PACKAGE_PATH": f"{arguments['output']}/remodel_order_behaviors:"
            f"{os.environ['ROS_PACKAGE_PATH']}",
        }
        given = [f"{name}:={value}" for name, value in arguments.items()]
        self._nodes = self._popen(["roslaunch", "-p", str(port), str(file), *given], "nodes.log")

    def order(self, database, *options, name="order.log"):
        """Start `remodel run`, and return its process; it prints to a file of the folder."""
        line = ["remodel", "run", ORDER, "--database", database]
        return self._popen([*line, "--output", str(self._folder / "report"), *options], name)

    def printed(self, name="order.log"):
        return (self._folder / name).read_text()

    def interrupt(self, limit_s=180.0):
        """End all nodes as Ctrl-C does, and return when they have ended."""
        if self._nodes.poll() is None:
            self._nodes.send_signal(signal.SIGINT)
            wait_until(lambda: self._nodes.poll() is not None, "the launch ends", limit_s)

    def _popen(self, line, log):
        with (self._folder / log).open("w") as file:
            return subprocess.Popen(
                line, stdout=file, stderr=subprocess.STDOUT, env=self._environment
            )
