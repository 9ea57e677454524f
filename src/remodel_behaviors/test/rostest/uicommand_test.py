#!/usr/bin/env python3
"""The commands of Deliverable 5.1, 4.2, as a person gives them, down to the behavior that runs."""

import difflib
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import rospkg
import rospy
import rostest
from flexbe_msgs.msg import BEStatus
from std_msgs.msg import String

from flexbe_core.testing import is_sent_to, wait_until

LIMIT_S = 90.0
KEY = "sesame"


class Heard:
    """What is said on a topic, waited for."""

    def __init__(self, topic, kind):
        self._changed = threading.Condition()
        self._seen = []
        self._subscriber = rospy.Subscriber(topic, kind, self._take)

    def _take(self, message):
        with self._changed:
            self._seen.append(message)
            self._changed.notify_all()

    def wait_for(self, test):
        with self._changed:
            return self._changed.wait_for(lambda: any(map(test, self._seen)), LIMIT_S)


class UiCommandTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Start console, engine and abilities on a copy of the behaviors, which commands write."""
        cls.folder = Path(tempfile.mkdtemp())
        cls.package = cls.folder / "remodel_behaviors"
        shutil.copytree(rospkg.RosPack().get_path("remodel_behaviors"), cls.package)
        os.mkfifo(cls.package / "charts" / "fifo.xml")  # who reads it waits forever
        cls.environment = {
            **os.environ,
            "ROS_PACKAGE_PATH": f"{cls.package}:{os.environ['ROS_PACKAGE_PATH']}",
            "PYTHONPATH": f"{cls.package / 'src'}:{os.environ['PYTHONPATH']}",
        }
        cls.notified = Heard("flexbe/uinotification", String)
        cls.statuses = Heard("flexbe/status", BEStatus)
        cls.processes = [
            cls.start("remodel_console", "command_server", f"_key:={KEY}"),
            cls.start("flexbe_onboard", "start_behavior"),
            cls.start("remodel_states", "fake_abilities"),
        ]
        answers = rospy.Subscriber("flexbe/uianswer", String, lambda _: None)
        assert wait_until(lambda: is_sent_to(answers)), "no console"

    @classmethod
    def tearDownClass(cls):
        for process in cls.processes:
            os.killpg(process.pid, signal.SIGINT)
            process.wait(60)
        shutil.rmtree(cls.folder)

    @classmethod
    def start(cls, *line):
        return subprocess.Popen(["rosrun", *line], env=cls.environment, start_new_session=True)

    def run_line(self, *line):
        return subprocess.run(
            line, env=self.environment, capture_output=True, text=True, timeout=180, check=False
        )

    def give(self, command, key=KEY):
        line = ("rosrun", "remodel_console", "uicommand", command, "--key", key)
        return self.run_line(*line)

    def test_load_synthesize_save_leave_a_behavior_that_runs(self):
        synthesize = "synthesize SynthesizedBehavior i: start g: TestBehaviorExample_descpt.xml"
        for command in ("load my_first_behavior", synthesize, "save"):
            done = self.give(command)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(self.notified.wait_for(lambda m, said=command: m.data == said))
        self.assertIn("saved 'my_first_behavior': wrote", done.stdout)
        self.assertTrue(self.statuses.wait_for(lambda status: status.code == BEStatus.READY))
        launcher = ("rosrun", "flexbe_widget", "be_launcher", "-b", "my_first_behavior")
        run = self.run_line(*launcher, "--input", "placepin_id='pin 7'")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        finished = (BEStatus.FINISHED, ["finished"])
        self.assertTrue(self.statuses.wait_for(lambda s: (s.code, list(s.args)) == finished))

    def test_a_note_adds_one_line_to_the_file_and_a_save_alone_none(self):
        file = self.package / "charts" / "place_connector.xml"
        before = file.read_bytes()
        for command in ("load Place Connector", "save", "check"):
            done = self.give(command)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(file.read_bytes(), before)
        for command in ("note Tried twice.", "save"):
            self.assertEqual(self.give(command).returncode, 0)
        old, new = before.decode().splitlines(), file.read_text().splitlines()
        changed = [line for line in difflib.ndiff(old, new) if line[0] in "+-"]
        self.assertEqual([line[0] for line in changed], ["-", "+", "+"])
        self.assertEqual(changed[0][2:].removesuffix(" -->"), changed[1][2:])
        self.assertEqual(changed[2].split(), ["+", "Tried", "twice.", "-->"])

    def test_the_line_of_the_deliverable_is_answered(self):
        answers = Heard("flexbe/uianswer", String)
        message = f"{{command: 'help', key: '{KEY}'}}"
        topic = ("flexbe/uicommand", "flexbe_msgs/UICommand", message)
        self.give("help")  # so that the console is there before a message that is not repeated
        publishing = subprocess.Popen(
            ["rostopic", "pub", *topic], env=self.environment, start_new_session=True
        )
        self.processes.append(publishing)
        said = "done: help\n"
        self.assertTrue(answers.wait_for(lambda m: m.data.startswith(said) and "load" in m.data))

    def test_without_a_console_the_command_does_not_wait_for_an_answer(self):
        line = ("rosrun", "remodel_console", "uicommand", "help", "--timeout", "600")
        done = self.run_line(*line, "__ns:=/elsewhere")  # within much less than that timeout
        self.assertEqual(done.returncode, 2)
        self.assertIn("no node serves /elsewhere/flexbe/uicommand; start it:", done.stderr)

    def test_a_wrong_key_is_refused_and_notified_by_an_empty_text(self):
        done = self.give("load Example Behavior", "open")
        self.assertEqual(done.returncode, 1)
        self.assertIn("the key is wrong", done.stderr)
        self.assertTrue(self.notified.wait_for(lambda message: message.data == ""))

    def test_what_fails_says_why_and_is_not_notified(self):
        done = self.give("load my_frist_behavior")
        self.assertEqual(done.returncode, 1)
        self.assertIn("Did you mean 'my_first_behavior'?", done.stderr)
        done = self.give("lock")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no behavior runs", done.stderr)


if __name__ == "__main__":
    rospy.init_node("test_uicommand")
    rostest.rosrun("remodel_behaviors", "test_uicommand", UiCommandTest)
