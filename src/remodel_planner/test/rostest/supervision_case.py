"""What the tests of killed processes share: a supervisor over a fake cell, and commands to it."""

import os
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import rosgraph
import rospy
from order_client import DESIGN
from remodel_msgs.msg import (
    RunUseCaseAction,
    RunUseCaseGoal,
    UseCaseState,
)

OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
LIMIT_S = 120.0


def planner(*line):
    """Run a command of the planner to its end."""
    line = ["remodel", *line, "--database", DATABASE]
    return subprocess.run(line, capture_output=True, text=True, timeout=180, check=False)


def call(name, kind, **request):
    """Call a service of the supervisor."""
    rospy.wait_for_service(f"remodel/use_case/{name}", 180.0)
    return rospy.ServiceProxy(f"remodel/use_case/{name}", kind)(**request)


class SupervisionCase(unittest.TestCase):
    """Runs tasks of an order, and kills nodes that roslaunch starts again."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_supervision")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        imported = planner("import", DESIGN, "--order", "house")
        assert imported.returncode == 0, imported.stderr
        cls.states = []
        rospy.Subscriber("remodel/use_case/state", UseCaseState, cls.states.append)

    def wait(self, holds, what):
        end = time.monotonic() + LIMIT_S
        while not holds():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.01)

    def last(self):
        return self.states[-1] if self.states else UseCaseState()

    def pid(self, node):
        """Return a node's process; 0 if it does not answer."""
        try:
            return ServerProxy(rosgraph.Master("/test").lookupNode(f"/{node}")).getPid("/test")[2]
        except (OSError, rosgraph.MasterError):
            return 0

    def kill(self, node):
        """Kill a node, and return when roslaunch has started it again."""
        before = self.pid(node)
        os.kill(before, signal.SIGKILL)
        self.wait(lambda: self.pid(node) not in (0, before), f"{node} respawns")

    def start(self, tasks, again=True):
        """Have tasks for robots of the order done, and return the client when the run has begun."""
        client = actionlib.ActionClient("remodel/run_use_case", RunUseCaseAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(180.0)))
        free = (UseCaseState.IDLE, UseCaseState.ENDED)
        self.wait(lambda: self.last().phase in free, "no run is under way")
        run = self.last().run
        goal = RunUseCaseGoal(id="test", order="house", tasks=tasks, again=again)
        handle = client.send_goal(goal)
        self.wait(lambda: self.last().run > run, "the run begins")
        return handle

    def task_running(self):
        return bool(self.last().task)
