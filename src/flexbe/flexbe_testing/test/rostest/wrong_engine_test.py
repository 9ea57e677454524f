#!/usr/bin/env python3
"""engine_conformance fails where an engine breaks a rule.

The engine is a real one behind a relay that changes what passes.
"""

import json
import subprocess
import unittest

import rospy
import rostest
from flexbe_msgs.msg import BEStatus
from wrong_engine import WrongEngine
from wrong_rules import RULES, changed, status

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import Verdict
from flexbe_testing.ros.conformance import ALL, FIRST, Judge
from flexbe_testing.ros.scenarios import starting

SCENARIOS = {scenario.name: scenario for scenario in ALL}

# [s] What the engine gets for each step, in the first try and in the second.
LIMITS_S = (0.6, 6.0)

# Broken by hand in tests of their own.
BY_HAND = {"ready", "status-is-latched", "topic-types", "mirror-publishes-paths"}


class WrongEngineTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.engine = WrongEngine({topics.STATUS: changed(status(BEStatus.READY), behavior_id=5)})
        cls.judge = Judge(quiet_s=0.12)
        cls.first = cls.judge.play(starting.ready)
        cls.engine.rest()

    def tearDown(self):
        self.engine.rest()

    def play(self, name):
        finding = self.judge.play(SCENARIOS[name])
        self.engine.rest()
        return finding

    def play_wrong(self, name, text, faults):
        """Play with a short limit; if another step was late on a busy machine, with a long one."""
        for limit_s in LIMITS_S:
            self.judge.bench.limit_s = limit_s
            self.judge.bench.wire.tape.beats.clear()
            self.engine.faults.update(faults)
            finding = self.play(name)
            if text in finding.reason:
                break
        return finding

    def assert_fails(self, finding, text):
        self.assertIs(finding.verdict, Verdict.FAIL, finding)
        self.assertIn(text, finding.reason)

    def setUp(self):
        self.judge.bench.limit_s = LIMITS_S[-1]

    def test_0_the_relay_itself_breaks_nothing(self):
        self.assertIs(self.judge.play(FIRST).verdict, Verdict.PASS)
        for name in ("outcomes-lead-a-mirror", "action-succeeds", "get-userdata"):
            finding = self.play(name)
            self.assertIs(finding.verdict, Verdict.PASS, finding)

    def test_every_broken_rule_is_found(self):
        missed = [
            (name, list(faults), text, str(finding))
            for faults, reasons in RULES
            for name, text in reasons.items()
            if (finding := self.play_wrong(name, text, faults)).verdict is not Verdict.FAIL
            or text not in finding.reason
        ]
        self.assertEqual(missed, [])

    def test_every_scenario_can_fail(self):
        broken = {name for _, reasons in RULES for name in reasons}
        self.assertEqual(broken | BY_HAND, set(SCENARIOS))

    def test_a_ready_status_with_an_id(self):
        self.assert_fails(self.first, "READY carries id 5")

    def test_a_status_that_is_not_latched(self):
        self.engine.set_latched(False)
        self.judge.bench.limit_s = LIMITS_S[0]
        finding = self.play("status-is-latched")
        self.engine.set_latched(True)
        self.assert_fails(finding, "flexbe/status")

    def test_a_topic_of_another_type(self):
        self.judge.bench.wire.topic_types = lambda: {"/flexbe/command/pause": "std_msgs/Empty"}
        finding = self.play("topic-types")
        del self.judge.bench.wire.topic_types
        self.assert_fails(finding, "flexbe/command/pause has type std_msgs/Empty")

    def test_a_mirror_that_publishes_nothing(self):
        self.judge.bench.limit_s = LIMITS_S[0]
        self.judge.bench.mirrors = lambda: ["/mirror"]
        finding = self.play("mirror-publishes-paths")
        del self.judge.bench.mirrors
        self.assert_fails(finding, "not on flexbe/behavior_update")

    def test_the_command_has_an_exit_code_and_a_table(self):
        self.engine.faults[topics.SYNC] = lambda message, engine: []
        words = "--json --limit 10 --only sync --only repeat"
        done = subprocess.run(
            ["rosrun", "flexbe_testing", "engine_conformance", *words.split()],
            capture_output=True,
            text=True,
            timeout=300,
        )
        self.assertEqual(done.returncode, 1, done.stderr)
        found = {row["scenario"]: row["verdict"] for row in json.loads(done.stdout)}
        self.assertEqual(found, {"runs-behaviors": "pass", "sync": "FAIL", "repeat": "pass"})


if __name__ == "__main__":
    rospy.init_node("test_wrong_engine")
    rostest.rosrun("flexbe_testing", "test_wrong_engine", WrongEngineTest)
