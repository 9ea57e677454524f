#!/usr/bin/env python3
"""Commands that arrive while a behavior is prepared, and those without supervision."""

import tempfile
import unittest
from pathlib import Path

import rospy
import rostest
from flexbe_msgs.msg import BEStatus
from onboard_test import Engine, Recorder
from std_msgs.msg import Bool, Empty, String, UInt8

COMMANDS = {"pause": Bool, "lock": String, "unlock": String, "autonomy": UInt8, "preempt": Empty}
COMMANDS["attach"] = UInt8


class PreparingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.engine = Engine()
        cls.beats = Recorder("flexbe/heartbeat", Empty)
        for name, message_type in COMMANDS.items():
            cls.engine.publisher(f"command/{name}", message_type)
        assert cls.engine.status.wait(lambda m: m.code == BEStatus.READY)

    def setUp(self):
        self.gate = Path(self.enterContext(tempfile.TemporaryDirectory())) / "gate"

    def tearDown(self):
        self.begin()
        if not self.engine.ended(0.0):
            self.engine.stop()
            self.engine.ended()

    def prepare(self, level=3, **commands):
        """Send commands to a behavior that is being prepared, and let it begin when they are in."""
        self.gate.unlink(missing_ok=True)
        self.engine.start("Gated Test", level=level, gate=self.gate)
        self.assertIsNotNone(self.engine.log.wait(lambda m: m.text == "waiting at the gate"))
        for name, value in commands.items():
            arguments = () if value is None else (value,)
            self.engine.send(f"command/{name}", COMMANDS[name](*arguments))
            self.let_arrive()

    def let_arrive(self):
        self.beats.clear()
        self.assertIsNotNone(self.beats.wait(lambda m: True), "by now the command has arrived")

    def begin(self, text=""):
        # Whole at once: the behavior reads the gate as soon as it is there.
        ready = self.gate.with_suffix(".ready")
        ready.write_text(text)
        ready.replace(self.gate)

    def said(self):
        return [m.text for _, m in self.engine.log.messages if m.text in ("first", "second")]

    def assert_answered(self, command):
        self.assertIsNotNone(self.engine.feedback.wait(lambda m: m.command == command))

    def assert_finishes(self, outcome="finished"):
        status = self.engine.ended()
        self.assertIsNotNone(status, "never ends")
        self.assertEqual((status.code, status.args), (BEStatus.FINISHED, [outcome]))

    def test_a_pause_holds_before_the_first_state(self):
        self.prepare(pause=True)
        self.begin()
        self.assert_answered("pause")
        self.assertIsNone(self.engine.ended(0.5))
        self.assertEqual(self.said(), [])
        self.engine.send("command/pause", Bool(False))
        self.assert_finishes()
        self.assertTrue(self.engine.log.wait(lambda m: m.text == "second"))
        self.assertEqual(self.said(), ["first", "second"])

    def test_a_pause_that_was_ended_again_holds_nothing(self):
        self.prepare(pause=True)
        self.engine.send("command/pause", Bool(False))
        self.let_arrive()
        self.begin()
        self.assert_finishes()

    def test_a_lock_holds_in_the_first_state(self):
        self.prepare(lock="/First")
        self.begin()
        self.assert_answered("lock")
        self.assertIsNone(self.engine.ended(0.5))
        self.assertEqual(self.said(), ["first"])
        self.engine.send("command/unlock", String("/First"))
        self.assert_finishes()

    def test_a_lower_autonomy_asks_at_the_first_transition(self):
        self.prepare(autonomy=0)
        self.begin()
        request = self.engine.requests.wait(lambda m: m.outcome != 255)
        self.assertEqual(request.target, "/First")
        self.engine.send("command/autonomy", UInt8(3))
        self.assert_finishes()

    def test_who_attaches_to_an_unsupervised_behavior_can_pause_it_before_it_begins(self):
        self.prepare(level=255, attach=3, pause=True)
        self.begin()
        self.assert_answered("attach")
        self.assert_answered("pause")
        self.assertIsNone(self.engine.ended(0.5))
        self.assertEqual(self.said(), [])

    def test_a_preempt_stops_it_before_the_first_state(self):
        self.prepare(preempt=None)
        self.begin()
        self.assert_finishes("preempted")
        self.assertEqual(self.said(), [])

    def test_what_it_waits_for_is_reported_and_a_preempt_ends_the_wait(self):
        self.prepare()
        self.begin("wait")
        waits = "waiting up to 600 s for action server nobody/serves"
        self.assertIsNotNone(self.engine.log.wait(lambda m: m.text == waits))
        self.engine.send("command/preempt", Empty())
        self.assert_finishes("preempted")
        self.assertEqual(self.said(), [])

    def test_what_a_behavior_that_was_not_started_got_does_not_hold_for_the_next(self):
        self.prepare(pause=True)
        self.begin("fail")
        self.assertEqual(self.engine.ended().code, BEStatus.ERROR)
        self.prepare()
        self.begin()
        self.assert_finishes()

    def test_a_pause_of_an_unsupervised_behavior_is_answered_in_words_and_has_no_effect(self):
        self.prepare(level=255, pause=True)
        self.begin()
        self.assert_finishes()
        logged = self.engine.log.wait(
            lambda m: m.text.startswith("pause has no effect: the behavior is not supervised")
        )
        self.assertIn("(autonomy 255); attach to it first", logged.text)
        self.assertEqual([m.command for _, m in self.engine.feedback.messages], [])


if __name__ == "__main__":
    rospy.init_node("test_preparing")
    rostest.rosrun("flexbe_onboard", "test_preparing", PreparingTest)
