#!/usr/bin/env python3
"""Engine and action server when the ROS master is restarted on the same port."""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rosgraph
import rostest

from flexbe_core.testing import wait_until

LIMIT_S = 90.0
NODES = ("/behavior", "/behavior_action_server")
# What they subscribe to last while they are set up.
SUBSCRIBED = {"/flexbe/start_behavior", "/flexbe/execute_behavior/cancel"}

# A node that takes its time between joining a master and serving.
LATE_NODE = """
import sys
from flexbe_core.ros.master import join, spin
join("late")
print("joined", flush=True)
sys.stdin.readline()
sys.exit(spin())
"""


class MasterRestartTest(unittest.TestCase):
    def setUp(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.uri = f"http://127.0.0.1:{self.port}"
        folder = self.enterContext(tempfile.TemporaryDirectory())
        self.env = {**os.environ, "ROS_MASTER_URI": self.uri, "ROS_LOG_DIR": folder}
        self.output = Path(folder) / "output.log"

    def start(self, *line, **options):
        with self.output.open("a") as output:
            process = subprocess.Popen(
                line, env=self.env, stdout=output, stderr=subprocess.STDOUT, text=True, **options
            )
        self.addCleanup(self.stop, process)
        return process

    def stop(self, process):
        process.send_signal(signal.SIGINT)
        process.wait(LIMIT_S)

    def start_master(self):
        roscore = self.start("roscore", "-p", str(self.port))
        master = rosgraph.Master("/test", master_uri=self.uri)
        self.assertTrue(wait_until(lambda: answers(master.getParam, "/run_id")), self.log())
        return roscore

    def log(self):
        return self.output.read_text()

    def nodes(self):
        """Return the addresses of the nodes that the master knows; None if it misses one."""
        master = rosgraph.Master("/test", master_uri=self.uri)
        found = [answers(master.lookupNode, name) for name in NODES]
        return found if all(found) else None

    def are_set_up(self):
        master = rosgraph.Master("/test", master_uri=self.uri)
        _, subscribers, _ = master.getSystemState()
        return set(dict(subscribers)) >= SUBSCRIBED

    def test_both_report_it_and_are_respawned_into_the_new_master(self):
        roscore = self.start_master()
        self.start("roslaunch", "flexbe_widget", "flexbe_action_server.launch")
        self.assertTrue(wait_until(self.are_set_up), self.log())
        former = self.nodes()
        self.stop(roscore)
        self.start_master()
        # A node of the former master may have called the new one, which then knows its address.
        self.assertTrue(
            wait_until(lambda: not set(former) & set(self.nodes() or former)), self.log()
        )
        log = self.log()
        sentence = f"the ROS master at {self.uri} was restarted: nodes that joined the former one"
        self.assertEqual(log.count(sentence), len(NODES), log)
        for name in NODES:
            self.assertTrue(re.search(rf"\[{name[1:]}-\d+\].*exit code 69", log), log)

    def test_a_node_reports_a_restart_while_it_was_set_up(self):
        roscore = self.start_master()
        late = self.start(sys.executable, "-c", LATE_NODE, stdin=subprocess.PIPE)
        self.assertTrue(wait_until(lambda: "joined" in self.log()), self.log())
        self.stop(roscore)
        self.start_master()
        late.communicate("serve\n", LIMIT_S)
        self.assertEqual(late.returncode, 69, self.log())


def answers(call, argument):
    """Return what the master answers; None if it does not know, or does not answer."""
    try:
        return call(argument)
    except (OSError, rosgraph.MasterError):
        return None


if __name__ == "__main__":
    rostest.rosrun("flexbe_widget", "test_master_restart", MasterRestartTest)
