#!/usr/bin/env python3
"""be_launcher: from the command line, from its launch file, and by topic."""

import os
import signal
import subprocess
import sys
import unittest
from xmlrpc.client import ServerProxy

import rosgraph
import rospkg
import rospy
import rostest
from flexbe_msgs.msg import BEStatus
from std_msgs.msg import Empty

from flexbe_core.testing import wait_until
from flexbe_widget.core.run_watch import ExitCode

LAUNCHER = ["rosrun", "flexbe_widget", "be_launcher"]
LIMIT_S = 90.0


class LauncherTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.statuses = []
        rospy.Subscriber("flexbe/status", BEStatus, cls.statuses.append)
        assert wait_until(lambda: cls.statuses)

    def setUp(self):
        self.statuses.clear()

    def launch(self, *words, **environment):
        """Run be_launcher to its end; return its exit code and what it printed."""
        done = subprocess.run(
            [*LAUNCHER, *words],
            env={**os.environ, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LIMIT_S,
        )
        return done.returncode, done.stdout

    def begin(self, *words):
        """Start be_launcher, and return when the behavior runs."""
        launcher = subprocess.Popen([*LAUNCHER, *words], stdout=subprocess.PIPE, text=True)
        self.assertTrue(wait_until(lambda: any(s.code == BEStatus.STARTED for s in self.statuses)))
        return launcher

    def test_a_name_with_blanks_runs_and_the_outcome_is_printed(self):
        code, printed = self.launch("-b", "Quick Test")
        self.assertEqual(code, ExitCode.FINISHED, printed)
        self.assertIn("'Quick Test' is at /Wait", printed)
        self.assertIn("'Quick Test' ended with outcome 'finished'", printed)

    def test_parameters_and_inputs_arrive(self):
        inputs = ("--input", "part={'pins': [7]}", "-i", "name=B")
        code, printed = self.launch("wait_time:=0", "-a", "255", "-b", "Input Test", *inputs)
        self.assertEqual(code, ExitCode.FINISHED, printed)
        self.assertIn("pins [7] of B", printed)

    def test_a_failing_state_has_an_exit_code_and_a_reason(self):
        code, printed = self.launch("-b", "Faulty Test")
        self.assertEqual(code, ExitCode.FAILED, printed)
        self.assertIn("/Faulty: RuntimeError: no camera image", printed)

    def test_an_unknown_behavior_names_near_ones(self):
        code, printed = self.launch("-b", "quick tests")
        self.assertEqual(code, ExitCode.UNKNOWN_BEHAVIOR)
        self.assertIn("unknown behavior 'quick tests'; near it: 'Quick Test'", printed)

    def test_a_refused_start_says_why(self):
        code, printed = self.launch("-b", "Quick Test", "wait_time:=soon")
        self.assertEqual(code, ExitCode.REFUSED)
        self.assertIn("parameter '/wait_time' takes a value of type float, found 'soon'", printed)

    def test_a_stopped_behavior_has_an_exit_code(self):
        stop = rospy.Publisher("flexbe/commands/preempt", Empty, queue_size=1)
        launcher = self.begin("-b", "Quick Test", "wait_time:=60")
        wait_until(lambda: stop.get_num_connections() > 0)
        stop.publish()
        self.assertIn("was stopped", launcher.communicate(timeout=LIMIT_S)[0])
        self.assertEqual(launcher.returncode, ExitCode.PREEMPTED)

    def test_a_busy_engine_is_waited_for_up_to_a_bound(self):
        stop = rospy.Publisher("flexbe/commands/preempt", Empty, queue_size=1)
        first = self.begin("-b", "Quick Test", "wait_time:=60")
        code, printed = self.launch("-b", "Quick Test", "--wait", "1")
        self.assertEqual(code, ExitCode.NO_ENGINE)
        self.assertIn("the engine runs another behavior", printed)
        words = ("-b", "Quick Test", "wait_time:=0", "--wait", f"{LIMIT_S}")
        second = subprocess.Popen([*LAUNCHER, *words], stdout=subprocess.PIPE, text=True)
        while "the engine runs another behavior" not in second.stdout.readline():
            self.assertIsNone(second.poll())
        wait_until(lambda: stop.get_num_connections() > 0)
        stop.publish()
        first.communicate(timeout=LIMIT_S)
        self.assertEqual(first.returncode, ExitCode.PREEMPTED)
        printed, _ = second.communicate(timeout=LIMIT_S)
        self.assertEqual(second.returncode, ExitCode.FINISHED, printed)

    def test_no_engine_is_reported_and_given_up(self):
        code, printed = self.launch("-b", "Quick Test", "--wait", "1", "__ns:=nobody")
        self.assertEqual(code, ExitCode.NO_ENGINE)
        self.assertIn("there is no behavior engine", printed)

    def test_an_engine_of_another_version_is_reported(self):
        other = (
            "import runpy, sys; from flexbe_msgs.msg import BehaviorSelection; "
            "BehaviorSelection._md5sum = '0' * 32; del sys.argv[0]; "
            "runpy.run_path(sys.argv[0], run_name='__main__')"
        )
        node = rospkg.RosPack().get_path("flexbe_widget") + "/nodes/be_launcher"
        words = [sys.executable, "-c", other, node, "-b", "Quick Test", "--wait", f"{LIMIT_S}"]
        launcher = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        while "the engine does not listen to this node" not in launcher.stdout.readline():
            self.assertIsNone(launcher.poll())
        launcher.send_signal(signal.SIGINT)
        launcher.communicate(timeout=LIMIT_S)
        self.assertEqual(launcher.returncode, ExitCode.INTERRUPTED)

    def test_no_master_is_reported_and_given_up(self):
        nowhere = "http://localhost:1"
        code, printed = self.launch("-b", "Quick Test", "-w", "0.5", ROS_MASTER_URI=nowhere)
        self.assertEqual(code, ExitCode.NO_ENGINE, printed)
        self.assertIn(f"no ROS master at {nowhere}", printed)

    def test_an_engine_that_is_killed_leaves_no_client_waiting(self):
        launcher = self.begin("-b", "Quick Test", "wait_time:=60")
        uri = rosgraph.Master(rospy.get_name()).lookupNode("/behavior")
        os.kill(ServerProxy(uri).getPid(rospy.get_name())[2], signal.SIGKILL)
        printed, _ = launcher.communicate(timeout=LIMIT_S)
        self.assertEqual(launcher.returncode, ExitCode.ENGINE_LOST, printed)
        ready = wait_until(lambda: self.statuses and self.statuses[-1].code == BEStatus.READY)
        self.assertTrue(ready, "the engine was not restarted")

    def test_the_launch_file_keeps_blanks(self):
        roslaunch = subprocess.run(
            ["roslaunch", "flexbe_widget", "be_launcher.launch", "behavior_name:=Quick Test"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LIMIT_S,
        )
        self.assertIn("'Quick Test' ended with outcome 'finished'", roslaunch.stdout)


if __name__ == "__main__":
    rospy.init_node("test_launcher")
    rostest.rosrun("flexbe_widget", "test_launcher", LauncherTest)
