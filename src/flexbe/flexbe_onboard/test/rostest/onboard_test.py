#!/usr/bin/env python3
"""The engine node, from outside, besides the wire protocol: that, engine_conformance judges."""

import os
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import actionlib
import rospy
import rostest
import yaml
from actionlib.msg import TestAction, TestResult
from actionlib_msgs.msg import GoalStatusArray
from flexbe_msgs.msg import (
    BehaviorLog,
    BehaviorModification,
    BehaviorSelection,
    BEStatus,
    CommandFeedback,
    OutcomeRequest,
)
from std_msgs.msg import Empty, String, UInt8

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.supervision import checksum
from flexbe_core.engine.visit import Known, VisitText
from flexbe_core.testing import is_sent_to, wait_until

LIMIT_S = 90.0
NOTICED_S = 60.0  # in which a dead server is noticed; mostly within one, if the machine is idle


class Recorder:
    """Remembers what comes on a topic, with the time it came at."""

    def __init__(self, topic, message_type):
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, message_type, self._on_message, tcp_nodelay=True)

    @property
    def is_connected(self):
        return is_sent_to(self._subscriber)

    def _on_message(self, message):
        self.messages.append((time.monotonic(), message))

    def wait(self, matches, limit_s=LIMIT_S):
        """Return the first message that matches, None if none comes in time."""
        found = wait_until(lambda: [m for _, m in self.messages if matches(m)], limit_s)
        return found[0] if found else None

    def time_of(self, matches):
        return next(at for at, message in self.messages if matches(message))

    def clear(self):
        self.messages = []

    def close(self):
        self._subscriber.unregister()


def visited(message):
    """Return the path of a state that was entered or left, and whether it was left."""
    visit = VisitText.from_json(message.data)
    return visit.path, visit.has_left


class Engine:
    """An engine, as its operators see it."""

    def __init__(self, namespace=""):
        self.library = BehaviorLibrary()
        self.status = Recorder(f"{namespace}flexbe/status", BEStatus)
        self.log = Recorder(f"{namespace}flexbe/log", BehaviorLog)
        self.updates = Recorder(f"{namespace}flexbe/behavior_update", String)
        self.feedback = Recorder(f"{namespace}flexbe/command_feedback", CommandFeedback)
        self.requests = Recorder(f"{namespace}flexbe/outcome_request", OutcomeRequest)
        self._namespace = namespace
        self._publishers = {}
        self.publisher("start_behavior", BehaviorSelection)
        assert wait_until(lambda: all(each.is_connected for each in self._recorders()))

    def publisher(self, name, message_type):
        topic = f"{self._namespace}flexbe/{name}"
        if topic not in self._publishers:
            publisher = rospy.Publisher(topic, message_type, queue_size=10, tcp_nodelay=True)
            wait_until(lambda: publisher.get_num_connections() > 0)
            self._publishers[topic] = publisher
        return self._publishers[topic]

    def send(self, name, message):
        self.publisher(name, type(message)).publish(message)

    def selection(self, name, level=255, inputs=None, **parameters):
        behavior_id, _ = self.library.find_behavior(name)
        text = Path(self.library.get_sourcecode_filepath(behavior_id)).read_text()
        inputs = inputs or {}
        return BehaviorSelection(
            behavior_id=behavior_id,
            behavior_checksum=checksum(text),
            autonomy_level=level,
            arg_keys=list(parameters),
            arg_values=[str(value) for value in parameters.values()],
            input_keys=list(inputs),
            input_values=list(inputs.values()),
        )

    def clear(self):
        for recorder in self._recorders():
            recorder.clear()

    def _recorders(self):
        return [each for each in vars(self).values() if isinstance(each, Recorder)]

    def start(self, *args, **kwargs):
        self.clear()
        selection = self.selection(*args, **kwargs)
        self.send("start_behavior", selection)
        return selection

    def ended(self, limit_s=LIMIT_S):
        """Return the status that ends a run, or refuses it."""
        ends = (BEStatus.FINISHED, BEStatus.FAILED, BEStatus.ERROR)
        return self.status.wait(lambda m: m.code in ends, limit_s)

    def is_at(self, path):
        return self.updates.wait(lambda m: m.data == path) is not None

    def is_mirrored(self):
        """Whether the mirror, which connects on its own, has published even a short first state."""
        self.start("Quick Test", wait_time=0)
        return self.ended() and self.updates.wait(lambda m: m.data == "/Say", 0.5) is not None

    def stop(self):
        self.send("command/preempt", Empty())


class HangingServer:
    """An action server that answers on command, or when it is cancelled."""

    def __init__(self, topic):
        self.goals, self.cancelled = [], Recorder(f"{topic}/cancel", actionlib.GoalID)
        self._server = actionlib.ActionServer(
            topic, TestAction, self._on_goal, lambda h: h.set_canceled(), auto_start=False
        )
        self._server.start()

    def _on_goal(self, handle):
        self.goals.append(handle)
        handle.set_accepted()

    def answer(self):
        self.goals[-1].set_succeeded(TestResult())


class OnboardTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(sys.argv[1])
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.engine = Engine()
        # One server for each topic: a second one would list its goals beside the first one's.
        cls.server = HangingServer("test_action")
        cls.open_server = HangingServer("open/test_action")
        assert cls.engine.status.wait(lambda m: m.code == BEStatus.READY)
        assert wait_until(cls.engine.is_mirrored), "the mirror does not follow the engine"

    def setUp(self):
        for server in (self.server, self.open_server):
            server.goals.clear()
            server.cancelled.clear()

    def assert_ends(self, code, args=(), limit_s=LIMIT_S):
        status = self.engine.ended(limit_s)
        self.assertIsNotNone(status, "no end in time")
        self.assertEqual((status.code, tuple(status.args)), (code, tuple(args)), self.log_texts())
        return status

    def log_texts(self):
        return [message.text for _, message in self.engine.log.messages]

    def assert_logged(self, text):
        found = self.engine.log.wait(lambda m: text in m.text)
        self.assertIsNotNone(found, f"{text!r} not in {self.log_texts()}")

    # Runs

    def test_a_behavior_runs_to_its_end(self):
        selection = self.engine.start("Quick Test", wait_time=0.2)
        status = self.assert_ends(BEStatus.FINISHED, ["finished"])
        self.assertEqual(status.behavior_id, selection.behavior_checksum)
        codes = [m.code for _, m in self.engine.status.messages]
        self.assertEqual(codes, [BEStatus.STARTED, BEStatus.FINISHED])
        self.assertTrue(self.engine.is_at("/Say"))
        self.assertTrue(self.engine.is_at("/Wait"))
        self.assert_logged("hello")

    def test_a_behavior_starts_at_a_state_only_where_that_is_allowed(self):
        text = {"text": "'from before'"}
        start = {"@start_at": "/Say"}
        self.engine.start("Input Test", inputs=text, **start)
        self.assert_ends(BEStatus.ERROR, [])
        self.assert_logged("start_at:=true")
        engine = Engine("open/")
        engine.start("Input Test", inputs=text, **start)
        self.assertEqual(engine.ended().code, BEStatus.FINISHED)
        self.assertIsNotNone(engine.log.wait(lambda m: m.text == "from before"))
        paths = [m.data for _, m in engine.updates.messages]
        self.assertIn("/Say", paths)
        self.assertNotIn("/Join", paths)
        engine.start("Input Test", **{"@start_at": "/Nowhere"})
        self.assertEqual(engine.ended().code, BEStatus.ERROR)
        refusal = "has no state '/Nowhere' to start at; it has: /Join, /Say, /Wait"
        self.assertIsNotNone(engine.log.wait(lambda m: refusal in m.text))

    def test_visits_of_states_are_published_with_the_values_they_find_and_leave(self):
        given = {"part": "{'pins': [1]}", "name": "A 7"}
        visits = Recorder("flexbe/mirror/visits", String)
        self.addCleanup(visits.close)
        self.assertTrue(wait_until(lambda: visits.is_connected))
        for _ in range(2):
            visits.clear()
            self.engine.start("Input Test", inputs=given, wait_time=0.0)
            self.assert_ends(BEStatus.FINISHED, ["finished"])
            self.assertIsNotNone(visits.wait(lambda m: visited(m) == ("/Wait", True)))
            found = [VisitText.from_json(m.data) for _, m in visits.messages]
            paths = ("/Join", "/Say", "/Wait")
            states = [(path, has_left) for path in paths for has_left in (False, True)]
            self.assertEqual([(v.path, v.has_left) for v in found], states)
            joined = ("str", "pins [1] of A 7")
            self.assertEqual(found[0].changed["", "part"], ("AttributeDict", "{'pins': [1]}"))
            self.assertEqual(found[1].changed, {("", "text"): joined})
            self.assertEqual([v.changed for v in found[2:]], [{}] * 4, "nothing is sent twice")

    def test_who_subscribes_during_a_run_gets_all_values_at_the_active_state(self):
        self.engine.start("Input Test", inputs={"name": "A 7"}, wait_time=30.0)
        self.assertTrue(self.engine.is_at("/Wait"))
        for _ in range(2):
            visits, known = Recorder("flexbe/mirror/visits", String), Known()
            at_wait = visits.wait(lambda m: visited(m) == ("/Wait", False))
            visits.close()
            self.assertIsNotNone(at_wait, "the state waits, and is not left")
            for _, message in visits.messages:
                self.assertTrue(known.take(VisitText.from_json(message.data)))
            self.assertEqual(known.values["", "name"], ("str", "A 7"))
        self.engine.stop()
        self.engine.ended()

    def test_two_engines_run_two_behaviors_at_once(self):
        other = Engine("open/")
        other.publisher("command/preempt", Empty)
        self.engine.start("Goal Test")
        other.start("Goal Test")
        self.assertTrue(wait_until(lambda: self.server.goals and self.open_server.goals))
        other.stop()
        self.assertEqual(other.ended().args, ["preempted"])
        self.assertIsNone(self.engine.ended(0.2), "a preempt is for one engine only")
        self.server.answer()
        self.assert_ends(BEStatus.FINISHED, ["finished"])

    # Preempt

    def preempt_goal(self, topic):
        self.engine.publisher(topic, Empty)
        self.engine.start("Goal Test")
        self.assertTrue(wait_until(lambda: self.server.goals))
        self.engine.send(topic, Empty())
        self.assert_ends(BEStatus.FINISHED, ["preempted"])
        self.assertIsNotNone(self.server.cancelled.wait(lambda m: True))
        self.assert_logged("stop of the goal state")
        self.assertEqual(self.log_texts().count("exit of the goal state"), 1)
        self.assertEqual(self.log_texts().count("stop of the goal state"), 1)

    def test_preempt_cancels_the_goal_and_exits_once(self):
        self.preempt_goal("command/preempt")

    def test_the_preempt_topic_of_the_deliverable_does_the_same(self):
        self.preempt_goal("commands/preempt")

    # Results

    def test_a_result_wakes_the_state_at_once(self):
        self.engine.start("Goal Test", rate=0.01)
        self.assertTrue(wait_until(lambda: self.server.goals))
        time.sleep(0.03)  # away from the moment of sending, where the state is executed anyway
        answered = time.monotonic()
        self.server.answer()
        self.assert_ends(BEStatus.FINISHED, ["finished"])
        ended = self.engine.status.time_of(lambda m: m.code == BEStatus.FINISHED)
        self.assertLess(ended - answered, 50.0, "a transition waited for a cycle of 100 s")
        self.assertEqual(self.server.cancelled.messages, [])

    # Failures

    def test_a_state_that_raises_ends_the_behavior_and_not_the_engine(self):
        self.engine.start("Faulty Test", how="raise")
        self.assert_ends(BEStatus.FAILED)
        self.assert_logged("/Faulty: RuntimeError: no camera image")
        self.engine.start("Quick Test", wait_time=0)
        self.assert_ends(BEStatus.FINISHED, ["finished"])

    def test_supervised_a_state_that_raises_is_held_for_the_operator(self):
        self.engine.start("Faulty Test", level=3, how="raise")
        self.assert_logged("it stays active and is tried again")
        self.assertIsNone(self.engine.ended(0.5))
        self.engine.send("command/transition", OutcomeRequest(0, "Faulty"))
        self.assert_ends(BEStatus.FINISHED, ["finished"])

    def test_a_state_that_does_not_return_is_reported_and_may_return_after_all(self):
        self.engine.start("Faulty Test", how="hang", hang_s=2.6)
        self.assert_logged("/Faulty has not returned for ")
        self.assert_ends(BEStatus.FINISHED, ["finished"])

    def test_an_engine_that_hangs_restarts_if_that_is_its_policy(self):
        engine = Engine("open/")
        engine.start("Faulty Test", how="hang")
        self.assertEqual(engine.ended().code, BEStatus.FAILED)
        self.assertIsNotNone(engine.status.wait(lambda m: m.code == BEStatus.READY))
        wait_until(
            lambda: engine.publisher("start_behavior", BehaviorSelection).get_num_connections()
        )
        engine.start("Quick Test", wait_time=0)
        self.assertEqual(engine.ended().args, ["finished"])

    def lose_server(self, **parameters):
        script = (
            "import rospy, actionlib; from actionlib.msg import TestAction;"
            "rospy.init_node('victim');"
            "s = actionlib.ActionServer('lost_action', TestAction, lambda h: h.set_accepted(),"
            " auto_start=False); s.start(); rospy.spin()"
        )
        serving = Recorder("lost_action/status", GoalStatusArray)
        victim = subprocess.Popen([sys.executable, "-c", script])
        try:
            # Its name is registered long before it serves.
            self.assertIsNotNone(serving.wait(lambda m: True))
            self.engine.start("Goal Test", topic="lost_action", **parameters)
            self.assertTrue(self.engine.is_at("/Goal"))
            self.assertIsNone(self.engine.ended(0.5), self.log_texts())
            os.kill(victim.pid, signal.SIGKILL)
            killed = time.monotonic()
            self.assertIsNotNone(self.engine.ended())
            return time.monotonic() - killed
        finally:
            victim.kill()
            victim.wait()

    def test_a_state_that_watches_notices_a_dead_server(self):
        self.assertLess(self.lose_server(), NOTICED_S)
        self.assert_ends(BEStatus.FINISHED, ["failed"])

    def test_a_state_that_does_not_watch_fails_when_its_server_dies(self):
        self.assertLess(self.lose_server(watch=False), NOTICED_S)
        self.assert_ends(BEStatus.FAILED)
        self.assert_logged("action server lost_action stopped during a goal")

    # Refusals

    def refuse(self, text, **changes):
        selection = self.engine.selection("Quick Test")
        for name, value in changes.items():
            setattr(selection, name, value)
        self.engine.clear()
        self.engine.send("start_behavior", selection)
        status = self.assert_ends(BEStatus.ERROR)
        self.assertEqual(status.behavior_id, selection.behavior_checksum)
        self.assert_logged(text)

    def test_an_unknown_behavior_is_refused_with_those_there_are(self):
        self.refuse("there is no behavior with id 5", behavior_id=5)
        self.assert_logged("Quick Test")

    def test_modifications_are_refused_with_the_argument_that_allows_them(self):
        self.refuse("modifications:=true", modifications=[BehaviorModification(0, 0, "x = 1\n")])

    def test_a_behavior_that_cannot_be_built_is_refused(self):
        self.engine.start("Faulty Test", how="build")
        self.assert_ends(BEStatus.ERROR)
        self.assert_logged("cannot build FaultySM: ValueError: nothing to build from")

    def test_a_second_start_is_refused_and_disturbs_nothing(self):
        first = self.engine.start("Quick Test", wait_time=0.8)
        self.assertTrue(self.engine.is_at("/Wait"))
        self.engine.send("start_behavior", self.engine.selection("Goal Test"))
        refused = self.assert_ends(BEStatus.ERROR)
        self.assertNotEqual(refused.behavior_id, first.behavior_checksum)
        self.assert_logged("behavior 'Quick Test' is running; stop it first")
        self.engine.feedback.wait(lambda m: "not_switchable" in m.args)  # on a topic of its own
        phases = [tuple(m.args) for _, m in self.engine.feedback.messages if m.command == "switch"]
        self.assertEqual(phases, [("received",), ("not_switchable",)])
        finished = self.engine.status.wait(lambda m: m.code == BEStatus.FINISHED)
        self.assertEqual(finished.behavior_id, first.behavior_checksum)

    # Sources

    def test_a_package_that_comes_later_and_changes_between_runs(self):
        packages = self.folder / "packages"
        source = packages / "late_behaviors" / "src" / "late_behaviors"
        try:
            self.write_late_package(source, "first")
            self.engine.start("Late Test")
            self.assert_ends(BEStatus.FINISHED, ["finished"])
            self.assert_logged("the first text")
            # As long as before and within the same second: Python would take its old bytecode.
            self.write_late_package(source, "other")
            self.engine.start("Late Test")
            self.assert_ends(BEStatus.FINISHED, ["finished"])
            self.assert_logged("the other text")
        finally:
            shutil.rmtree(packages, ignore_errors=True)

    @staticmethod
    def write_late_package(source, word):
        folder = source.parents[1]
        (folder / "manifest").mkdir(parents=True, exist_ok=True)
        source.mkdir(parents=True, exist_ok=True)
        (folder / "package.xml").write_text(
            "<package format='3'><name>late_behaviors</name><export><flexbe_behaviors/>"
            "<flexbe_states/></export></package>"
        )
        (folder / "manifest" / "late.xml").write_text(
            "<behavior name='Late Test'>"
            "<executable package_path='late_behaviors.late_sm' class='LateSM'/></behavior>"
        )
        (source / "__init__.py").write_text("")
        (source / "text.py").write_text(f"TEXT = 'the {word} text'\n")
        (source / "late_sm.py").write_text(
            "from flexbe_core import Behavior, OperatableStateMachine\n"
            "from flexbe_states.log_state import LogState\n"
            "from late_behaviors.text import TEXT\n"
            "class LateSM(Behavior):\n"
            "    def __init__(self):\n"
            "        super().__init__()\n"
            "        self.name = 'Late Test'\n"
            "    def create(self):\n"
            "        root = OperatableStateMachine(outcomes=['finished'])\n"
            "        with root:\n"
            "            OperatableStateMachine.add('Say', LogState(TEXT), {'done': 'finished'})\n"
            "        return root\n"
        )

    # Records

    def test_what_states_do_is_recorded_in_a_file(self):
        engine = Engine("open/")
        logs = self.folder / "logs"
        shutil.rmtree(logs, ignore_errors=True)
        engine.start("Quick Test", level=0, wait_time=0)
        self.assertIsNotNone(engine.requests.wait(lambda m: m.target == "/Say"))
        engine.send("command/transition", OutcomeRequest(0, "Say"))
        self.assertIsNotNone(engine.requests.wait(lambda m: m.target == "/Wait"))
        engine.send("command/autonomy", UInt8(3))
        self.assertEqual(engine.ended().args, ["finished"])
        (file,) = logs.glob("quick_test_*.yaml")
        lines = yaml.safe_load(file.read_text())
        shutil.rmtree(logs)
        self.assertEqual((lines[0]["behavior"], lines[0]["autonomy"]), ("Quick Test", 0))
        events = [line["event"] for line in lines if line.get("path") == "/Say" and "event" in line]
        self.assertEqual(events, ["start", "enter", "exit", "stop"])
        operator = [line["type"] for line in lines if line["logger"] == "flexbe.operator"]
        self.assertEqual(operator, ["request", "forced", "request"])
        outcomes = [line["path"] for line in lines if line["logger"] == "flexbe.outcomes"]
        self.assertEqual(outcomes, ["/Say", "/Wait"])

    # Switching

    def version_of(self, engine, old, new, **parameters):
        """Return a start request for Goal Test with a piece of its source replaced."""
        selection = engine.selection("Goal Test", **parameters)
        text = Path(engine.library.get_sourcecode_filepath(selection.behavior_id)).read_text()
        begin = text.index(old)
        changed = text[:begin] + new + text[begin + len(old) :]
        selection.behavior_checksum = checksum(changed)
        selection.modifications = [BehaviorModification(begin, begin + len(old), new)]
        return selection

    def begin_goal(self):
        engine = Engine("open/")
        engine.publisher("command/unlock", String)
        first = engine.start("Goal Test", level=3)
        self.assertTrue(wait_until(lambda: self.open_server.goals))
        return engine, first

    def test_a_running_behavior_is_switched_to_another_version(self):
        engine, first = self.begin_goal()
        second = self.version_of(engine, '"done": "finished"', '"done": "failed"', level=3)
        engine.send("start_behavior", second)
        started = engine.status.wait(lambda m: m.code == BEStatus.STARTED and m.args)
        self.assertIsNotNone(started, [m.text for _, m in engine.log.messages])
        self.assertEqual((started.behavior_id, started.args), (second.behavior_checksum, ["/Goal"]))
        switched = engine.status.wait(lambda m: m.code == BEStatus.SWITCHING)
        self.assertEqual(switched.behavior_id, first.behavior_checksum)
        engine.feedback.wait(lambda m: "prepared" in m.args)
        phases = [m.args[0] for _, m in engine.feedback.messages if m.command == "switch"]
        self.assertEqual(phases, ["received", "start", "prepared"])
        self.open_server.answer()
        self.assertIsNone(engine.ended(0.3), "it stays locked")
        self.assertEqual(self.open_server.cancelled.messages, [])
        engine.send("command/unlock", String("/Goal"))
        self.assertEqual(engine.ended().args, ["failed"])
        engine.log.wait(lambda m: m.text == "stop of the goal state")  # on a topic of its own
        logged = [m.text for _, m in engine.log.messages]
        self.assertEqual(logged.count("exit of the goal state"), 1)
        self.assertEqual(logged.count("stop of the goal state"), 1)

    def test_a_version_without_the_active_state_is_refused_and_disturbs_nothing(self):
        engine, first = self.begin_goal()
        engine.send("start_behavior", self.version_of(engine, '"Goal",', '"Other",', level=3))
        self.assertEqual(engine.ended().code, BEStatus.ERROR)
        failed = engine.feedback.wait(lambda m: m.args == ["failed"])
        self.assertIsNotNone(failed)
        self.assertIsNotNone(engine.log.wait(lambda m: "has no state '/Goal'" in m.text))
        self.open_server.answer()
        finished = engine.status.wait(lambda m: m.code == BEStatus.FINISHED)
        self.assertEqual(finished.behavior_id, first.behavior_checksum)


if __name__ == "__main__":
    rospy.init_node("test_onboard")
    rostest.rosrun("flexbe_onboard", "test_onboard", OnboardTest)
