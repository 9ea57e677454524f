#!/usr/bin/env python3
"""Every ability state, alone, against fake servers."""

import inspect
import os
import re
import signal
import subprocess
import sys
import threading
import time
import unittest
from contextlib import contextmanager
from importlib import import_module
from unittest import mock

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from geometry_msgs.msg import PoseStamped
from remodel_msgs.msg import AbilityRecord, ErrorCode
from remodel_msgs.srv import (
    BeginOperation,
    BeginOperationResponse,
    KeepRecord,
    KeepRecordResponse,
)
from std_msgs.msg import String

from flexbe_core import Logger
from flexbe_core.core import UserData
from flexbe_core.proxy import ProxyActionClient
from flexbe_core.testing import wait_until
from flexbe_synthesizer.core.library.sources import read_state_class
from remodel_states import line
from remodel_states.core.contract import GRACE_S, LATE_S
from remodel_states.core.state_source import module_name
from remodel_states.core.tables import POSE as POSE_TYPE
from remodel_states.core.tables import POSES as POSES_TYPE
from remodel_states.count_attempts_state import CountAttemptsState
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.place_pin_state import SLOW, PlacePinState
from remodel_states.testing import FakeAbility, FakeAnswer

POSE = [0.1, 0.2, 0.3, 1.5]
EXAMPLES = {POSE_TYPE: POSE, POSES_TYPE: [POSE, POSE], "string": "P1", "float64": 1.0}


def states():
    """Return ability -> (state's class, required parameters, outcome of success)."""
    found = {"PlacePin": (PlacePinState, {}, "PlacePin finished normally")}
    for name, row in read_abilities().items():
        if row.state and row.package == "remodel_msgs":
            module = import_module(f"remodel_states.{module_name(name)}")
            required = [p for p in row.state.parameters if p.is_required]
            given = {p.name: EXAMPLES[p.field.type] for p in required}
            found[name] = (getattr(module, f"{name}State"), given, row.state.outcome)
    return found


STATES = states()


def userdata():
    """Return userdata with every input that an ability state may read."""
    data = UserData()
    data["placepin_id"] = "placepin_id"
    for row in read_abilities().values():
        for field in row.state.inputs if row.state else ():
            data[field.name] = PoseStamped() if field.type == POSE_TYPE else field.name
    return data


def run(state, data, limit_s=90.0):
    """Run a lone state to its outcome, as flexbe_testing does."""
    state.on_start()
    limit = time.monotonic() + limit_s
    outcome = None
    while outcome is None and time.monotonic() < limit:
        outcome = state.execute(data)
        if outcome is None:
            state.sleep()
    return outcome


def documented_writes(state_class):
    """Return what a state's docstring says that each outcome writes."""
    entries = re.findall(r"<= (.+?)(?=<= |\Z)", state_class.__doc__, re.DOTALL)
    found = {}
    for entry in entries:
        outcome, keys = re.match(r"(.+?)  .*?\[writes (.*?)\]", entry, re.DOTALL).groups()
        found[outcome] = set() if keys == "nothing" else set(keys.split(", "))
    return found


GRANTED = BeginOperationResponse(BeginOperationResponse.GRANTED, 17, "")
HELD = BeginOperationResponse(BeginOperationResponse.HELD, 0, "paused by ann")
REFUSED = BeginOperationResponse(BeginOperationResponse.REFUSED, 0, "the behavior is stopped")


class Recorder:
    """A supervisor that grants at once, and keeps records when it may."""

    def __init__(self, namespace):
        self.came = []
        self.may_answer = threading.Event()
        self.may_answer.set()
        self.says = KeepRecordResponse(True, "")
        self.asked = []
        self.may_begin = threading.Event()
        self.may_begin.set()
        self.permits = GRANTED
        self._services = (
            rospy.Service(f"{namespace}/keep_record", KeepRecord, self._on_record),
            rospy.Service(f"{namespace}/begin_operation", BeginOperation, self._on_begin),
        )

    def stop(self):
        self.may_answer.set()
        self.may_begin.set()
        for service in self._services:
            service.shutdown()

    def _on_record(self, request):
        self.came.append(request.record)
        self.may_answer.wait(90.0)
        return self.says

    def _on_begin(self, request):
        self.asked.append((request.behavior, request.state_path, request.ability))
        answer = self.permits
        self.may_begin.wait(90.0)
        return answer


@contextmanager
def recorded_by(service):
    """Have records kept by a service."""
    rospy.set_param(line.RECORDER_PARAMETER, service)
    try:
        yield
    finally:
        if rospy.has_param(line.RECORDER_PARAMETER):
            rospy.delete_param(line.RECORDER_PARAMETER)


@contextmanager
def process(script):
    """Run a Python program, and kill it in the end."""
    started = subprocess.Popen([sys.executable, "-c", script])
    try:
        yield started
    finally:
        started.kill()
        started.wait()


class AbilityStatesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.fakes = {ability: FakeAbility(ability) for ability in STATES}
        cls.records = []
        rospy.Subscriber("remodel/ability_records", AbilityRecord, cls.records.append)

    def state(self, ability, **parameters):
        state_class, defaults, _ = STATES[ability]
        return state_class(**{**defaults, **parameters})

    @contextmanager
    def recorder(self):
        """Have records kept by a recorder of this test."""
        namespace = f"recorder_of/{self._testMethodName}"
        recorder = Recorder(namespace)
        try:
            with recorded_by(f"{namespace}/keep_record"):
                yield recorder
        finally:
            recorder.stop()

    def check_writes(self, state, outcome):
        """Run a state to an outcome; return what it writes, which must be as documented."""
        given, data = userdata(), UserData()
        for key in state.input_keys:
            data[key] = given[key]
        self.assertEqual(run(state, data), outcome)
        state.on_exit(data)
        written = {key: data[key] for key in state.output_keys if key in data}
        self.assertEqual(set(written), documented_writes(type(state))[outcome])
        return written

    def test_each_outcome_writes_what_the_docstring_says_with_the_code_of_a_failure(self):
        for ability, (_, _, done) in STATES.items():
            answers = {
                done: (FakeAnswer(), None),
                "failed": (FakeAnswer(ErrorCode.NOT_SEATED), ErrorCode.NOT_SEATED),
                "command_error": (FakeAnswer(refuse=True), ErrorCode.INVALID_GOAL),
            }
            outcomes = set(self.state(ability).outcomes)
            self.assertEqual(outcomes, set(documented_writes(STATES[ability][0])))
            self.assertEqual(outcomes - set(answers), {SLOW} if ability == "PlacePin" else set())
            for outcome, (answer, code) in answers.items():
                self.fakes[ability].script(answer)
                written = self.check_writes(self.state(ability), outcome)
                self.assertEqual(written.get("error_code"), code, ability)
                if code == ErrorCode.NOT_SEATED:
                    self.assertIn("304", written["error_message"], ability)
                goal = self.fakes[ability].goals[0]
                self.assertTrue(goal.id, ability)
                self.assertGreater(goal.timeout, 0, ability)
        self.fakes["PlacePin"].script(FakeAnswer())
        self.check_writes(self.state("PlacePin", max_time=-1.0), SLOW)

    def test_success_leaves_the_last_failure_in_userdata(self):
        fake = self.fakes["InsertCable"]
        fake.script(FakeAnswer(ErrorCode.INSERTION_JAMMED), FakeAnswer())
        data = userdata()
        state = self.state("InsertCable")
        self.assertEqual(run(state, data), "failed")
        self.assertEqual(run(state, data), "inserted")
        self.assertEqual(data["error_code"], ErrorCode.INSERTION_JAMMED)
        self.assertNotEqual(fake.goals[0].id, fake.goals[1].id)

    def test_a_server_that_never_answers_is_given_up_and_cancelled(self):
        self.fakes["FixCable"].script(FakeAnswer(hang=True))
        data = userdata()
        self.assertEqual(run(self.state("FixCable", timeout_s=0.3), data), "failed")
        self.assertEqual(data["error_code"], ErrorCode.SERVER_HUNG)
        self.assertTrue(wait_until(lambda: self.fakes["FixCable"].cancelled))

    def test_a_server_that_ignores_the_cancel_too_keeps_the_bound_of_the_certificate(self):
        topic = "stubborn/fixcable"
        fake = FakeAbility("FixCable", [FakeAnswer(hang=True)], topic)
        state = self.state("FixCable", timeout_s=0.3, topic=topic)
        source = inspect.getsource(import_module(type(state).__module__))
        read = read_state_class(source, "remodel_states", type(state).__module__)
        (limit,) = (each for each in read.parameters if each.name == "timeout_s")
        data = userdata()
        with mock.patch.object(FakeAbility, "cancel"):
            state.on_start()
            while not fake.goals:
                self.assertIsNone(state.execute(data))
                state.sleep()
            started = executed = time.monotonic()
            while (outcome := state.execute(data)) is None:
                last_s = executed - started
                state.sleep()
                executed = time.monotonic()
            took_s = executed - started
            state.on_exit(data)
        self.assertEqual(outcome, "failed")
        self.assertEqual(data["error_code"], ErrorCode.SERVER_HUNG)
        self.assertGreater(took_s, 0.3 + GRACE_S - 1.0, "not before the server's time is up")
        # An execution may come late on a busy machine; the first one after the bound ends it.
        self.assertLess(last_s, 0.3 + limit.grace_s)

    def test_a_result_that_contradicts_itself_is_not_believed(self):
        self.fakes["FixCable"].script(FakeAnswer(ErrorCode.PULLED_OUT, contradict=True))
        data = userdata()
        self.assertEqual(run(self.state("FixCable"), data), "failed")
        self.assertEqual(data["error_code"], ErrorCode.CONTRADICTORY_RESULT)
        self.assertIn("305", data["error_message"])

    def test_leaving_a_running_state_cancels_its_goal_once(self):
        fake = self.fakes["RouteWire"]
        fake.script(FakeAnswer(hang=True))
        state = self.state("RouteWire")
        data = userdata()
        started = rospy.Time.now()
        state.on_enter(data)
        self.assertTrue(wait_until(lambda: fake.goals))
        state.on_exit(data)
        state.on_stop()
        self.assertTrue(wait_until(lambda: fake.cancelled))
        self.assertEqual(fake.cancelled, [fake.goals[0].id])

        def codes():
            return [record.error_code for record in self.records if record.stamp >= started]

        self.assertTrue(wait_until(codes))
        self.assertEqual(codes(), [ErrorCode.PREEMPTED])

    def test_a_server_that_stood_still_begins_no_goal_that_reaches_it_late(self):
        script = (
            "import rospy; rospy.init_node('late'); from std_msgs.msg import String;"
            "from remodel_states.testing import FakeAbility, FakeAnswer;"
            "fake = FakeAbility('PickCable', [FakeAnswer(hang=True)], 'late/pickcable');"
            "publisher = rospy.Publisher('late/begun', String, latch=True, queue_size=1)\n"
            "while not rospy.is_shutdown():\n"
            "    rospy.rostime.wallsleep(0.05)\n"
            "    if fake.goals: publisher.publish(' '.join(goal.id for goal in fake.goals))"
        )
        begun, statuses = [], []
        rospy.Subscriber("late/begun", String, lambda message: begun.append(message.data))
        rospy.Subscriber(
            "late/pickcable/status",
            GoalStatusArray,
            lambda message: statuses.extend(message.status_list),
        )
        with process(script) as server:
            state, data = self.state("PickCable", topic="late/pickcable"), userdata()
            self.assertTrue(wait_until(lambda: state._call._client.is_available("late/pickcable")))
            server.send_signal(signal.SIGSTOP)
            stopped = rospy.get_time()
            self.assertEqual(run(state, data), "command_error")
            self.assertEqual(data["error_code"], ErrorCode.SERVER_LOST)
            self.assertTrue(wait_until(lambda: rospy.get_time() > stopped + LATE_S + 1.5))
            server.send_signal(signal.SIGCONT)
            # Without its cancel, which would end it, too: that was before `on_exit`.
            rejected = (GoalStatus.REJECTED, GoalStatus.RECALLED)
            self.assertTrue(wait_until(lambda: any(s.status in rejected for s in statuses)))
            self.assertEqual(begun, [])

    def test_a_server_that_stood_still_finds_its_goal_cancelled(self):
        script = (
            "import rospy; rospy.init_node('stalled'); from std_msgs.msg import String;"
            "from remodel_states.testing import FakeAbility, FakeAnswer;"
            "fake = FakeAbility('PickCable', [FakeAnswer(hang=True)], 'stalled/pickcable');"
            "publisher = rospy.Publisher('stalled/cancelled', String, latch=True, queue_size=1)\n"
            "while not rospy.is_shutdown():\n"
            "    rospy.rostime.wallsleep(0.05)\n"
            "    if fake.cancelled: publisher.publish(fake.cancelled[0])"
        )
        cancelled = []
        rospy.Subscriber("stalled/cancelled", String, lambda message: cancelled.append(message))
        with process(script) as server:
            state, data = self.state("PickCable", topic="stalled/pickcable"), userdata()
            self.assertIsNone(run(state, data, 0.5))
            server.send_signal(signal.SIGSTOP)
            self.assertEqual(run(state, data), "command_error")
            self.assertEqual(data["error_code"], ErrorCode.SERVER_LOST)
            state.on_exit(data)
            server.send_signal(signal.SIGCONT)
            self.assertTrue(wait_until(lambda: cancelled))

    def test_a_second_server_of_an_action_gets_no_goal_and_neither_does_the_first(self):
        script = (
            "import rospy; rospy.init_node('intruder');"
            "from remodel_states.testing import FakeAbility;"
            "FakeAbility('PickCable', topic='shared/pickcable'); rospy.spin()"
        )
        fake = FakeAbility("PickCable", topic="shared/pickcable")
        state, data = self.state("PickCable", topic="shared/pickcable"), userdata()
        self.assertEqual(run(state, data), "picked")
        client = ProxyActionClient()
        with process(script):
            self.assertTrue(wait_until(lambda: len(client.servers("shared/pickcable")) == 2))
            self.assertEqual(run(state, data), "command_error")
            self.assertEqual(data["error_code"], ErrorCode.SEVERAL_SERVERS)
            self.assertIn(f"/intruder and {rospy.get_name()}", data["error_message"])
            self.assertEqual(len(fake.goals), 1)
        self.assertTrue(wait_until(lambda: len(client.servers("shared/pickcable")) == 1))
        self.assertEqual(run(state, data), "picked")

    def test_a_client_that_knows_no_servers_sends_its_goal(self):
        self.fakes["FixCable"].script(FakeAnswer())
        with mock.patch.object(ProxyActionClient, "servers", None):
            self.assertEqual(run(self.state("FixCable"), userdata()), "fixed")

    def test_a_server_that_dies_is_noticed_long_before_the_timeout(self):
        script = (
            "import rospy; rospy.init_node('victim');"
            "from remodel_states.testing import FakeAbility, FakeAnswer;"
            "FakeAbility('PickCable', [FakeAnswer(hang=True)], 'victim/pickcable'); rospy.spin()"
        )
        with process(script) as victim:
            state = self.state("PickCable", topic="victim/pickcable", timeout_s=60.0)
            timer = threading.Timer(2.0, os.kill, (victim.pid, signal.SIGKILL))
            timer.start()
            data = userdata()
            self.assertEqual(run(state, data), "command_error")  # long before the goal's timeout
            self.assertEqual(data["error_code"], ErrorCode.SERVER_LOST)

    def test_no_server_is_a_command_error_at_once(self):
        state = self.state("DetectCable", topic="nobody/serves/this")
        data = userdata()
        self.assertEqual(run(state, data), "command_error")
        self.assertEqual(data["error_code"], ErrorCode.SERVER_LOST)

    def test_a_slow_pin_is_distinguished_from_a_normal_one(self):
        self.fakes["PlacePin"].script(FakeAnswer(elapsed_s=31.0))
        data = userdata()
        outcome = run(self.state("PlacePin", max_time=30.0), data)
        self.assertEqual(outcome, "PlacePin takes longer than normal")
        self.assertEqual(data["elapsed_time"], 31.0)

    def test_a_view_is_part_of_the_goal(self):
        for ability in ("DetectCable", "LocateGearboxComponent"):
            self.fakes[ability].script(FakeAnswer())
            run(self.state(ability, view=2), userdata())
            self.assertEqual(self.fakes[ability].goals[0].view, 2)
            run(self.state(ability), userdata())
            self.assertEqual(self.fakes[ability].goals[1].view, 0)

    def test_a_record_has_the_goal_and_what_was_found(self):
        self.fakes["InsertCable"].script(FakeAnswer())
        with self.recorder() as recorder:
            self.assertEqual(
                run(self.state("InsertCable", force_limit=9.5), userdata()), "inserted"
            )
        (record,) = recorder.came
        self.assertIn("force_limit=9.5", record.parameters)
        self.assertIn("cable_id=cable_id", record.parameters)
        (pose,) = [text for text in record.parameters if text.startswith("socket_pose=")]
        self.assertRegex(pose, r"^socket_pose=\S+( -?[0-9.]+){7}$")
        self.assertIn("peak_force=5.0", record.measurements)
        self.assertFalse([text for text in record.measurements if text.startswith("success")])

    def test_the_outcome_waits_until_the_record_is_kept(self):
        self.fakes["InsertCable"].script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.may_answer.clear()
            state, data = self.state("InsertCable"), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or recorder.came))
            for _ in range(20):
                self.assertIsNone(state.execute(data))
            recorder.may_answer.set()
            self.assertEqual(run(state, data), "inserted")
            self.assertEqual(recorder.came[0].outcome, "inserted")

    def test_a_recorder_that_is_killed_is_waited_for(self):
        script = (
            "import rospy; from remodel_msgs.srv import BeginOperation, KeepRecord;"
            "rospy.init_node('victim', anonymous=True);"
            "rospy.Service('victim/begin_operation', BeginOperation, lambda _: (0, 17, ''));"
            "rospy.Service('victim/keep', KeepRecord, lambda _: (True, '')); rospy.spin()"
        )
        self.fakes["InsertCable"].script(FakeAnswer())
        with recorded_by("victim/keep"):
            for _ in range(2):
                with process(script):
                    self.assertEqual(run(self.state("InsertCable"), userdata()), "inserted")

    def test_a_recorder_that_refuses_is_asked_again_without_limit_and_with_a_warning(self):
        self.fakes["FixCable"].script(FakeAnswer())
        with (
            self.recorder() as recorder,
            mock.patch.object(line, "WARN_EVERY_S", 0.3),
            mock.patch.object(Logger, "logwarn") as warn,
        ):
            recorder.says = KeepRecordResponse(False, "the disk is full")
            state, data = self.state("FixCable"), userdata()
            self.assertTrue(
                wait_until(lambda: state.execute(data) or len(warn.call_args_list) >= 2)
            )
            self.assertGreater(len(recorder.came), 1)
            text = warn.call_args[0][0]
            expected = (
                "keep_record has not accepted the request for 0.3 s or longer: the disk is full"
            )
            self.assertIn(expected, text)
            self.assertIn("rosparam delete /remodel/recorder", text)
            recorder.says = KeepRecordResponse(True, "")
            self.assertEqual(run(state, data), "fixed")
            self.assertEqual(recorder.came[0], recorder.came[-1])

    def test_a_goal_is_sent_only_when_it_is_granted_and_names_the_owner(self):
        fake = self.fakes["InsertCable"]
        fake.script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.may_begin.clear()
            state, data = self.state("InsertCable", timeout_s=0.5), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or recorder.asked))
            self.assertIsNone(run(state, data, 3.0))  # longer than the goal's timeout and grace
            self.assertEqual(fake.goals, [])
            recorder.may_begin.set()
            self.assertEqual(run(state, data), "inserted")
        self.assertEqual(recorder.asked, [("", state.path, "InsertCable")])
        self.assertEqual(fake.goals[0].id, f"17:{state.path}#1")
        self.assertEqual(recorder.came[0].goal_id, fake.goals[0].id)
        self.assertLess(recorder.came[0].elapsed_time, 3.0, "it counts from the grant")

    def test_a_held_operation_is_asked_for_again_until_the_run_resumes(self):
        fake = self.fakes["InsertCable"]
        fake.script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.permits = HELD
            state, data = self.state("InsertCable"), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or len(recorder.asked) > 2))
            # A master that lost its parameters must not end a pause.
            rospy.delete_param(line.RECORDER_PARAMETER)
            asked = len(recorder.asked)
            self.assertTrue(wait_until(lambda: state.execute(data) or len(recorder.asked) > asked))
            self.assertEqual(fake.goals, [])
            recorder.permits = GRANTED
            self.assertEqual(run(state, data), "inserted")

    def test_a_record_is_kept_while_another_state_is_held(self):
        self.fakes["InsertCable"].script(FakeAnswer())
        self.fakes["FixCable"].script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.may_answer.clear()
            insert, fix, data = self.state("InsertCable"), self.state("FixCable"), userdata()
            self.assertTrue(wait_until(lambda: insert.execute(data) or recorder.came))
            recorder.permits = HELD
            recorder.may_answer.set()
            self.assertIsNone(fix.execute(data))
            self.assertEqual(run(insert, data), "inserted")
            self.assertIsNone(run(fix, data, 0.5))
            fix.on_exit(data)

    def test_a_refused_operation_sends_no_goal_and_no_record(self):
        fake = self.fakes["InsertCable"]
        fake.script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.permits = REFUSED
            state, data = self.state("InsertCable"), userdata()
            published = len(self.records)
            self.assertEqual(run(state, data), "command_error")
            state.on_exit(data)
            self.assertEqual(data["error_code"], ErrorCode.PREEMPTED)
            self.assertIn("the behavior is stopped", data["error_message"])
            self.assertEqual(run(self.state("FixCable"), data), "command_error")
        self.assertEqual((fake.goals, recorder.came), ([], []))
        self.assertEqual(len(self.records), published)

    def test_a_state_that_is_left_while_it_asks_sends_nothing(self):
        fake = self.fakes["InsertCable"]
        fake.script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.permits = HELD
            state, data = self.state("InsertCable"), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or recorder.asked))
            state.on_exit(data)
            recorder.permits = GRANTED
            self.fakes["FixCable"].script(FakeAnswer())
            self.assertEqual(run(self.state("FixCable"), data), "fixed")
            self.assertEqual(fake.goals, [])
            self.assertEqual([record.ability for record in recorder.came], ["FixCable"])

    def test_a_grant_that_comes_after_the_state_was_left_is_given_back(self):
        fake = self.fakes["InsertCable"]
        fake.script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.may_begin.clear()
            state, data = self.state("InsertCable"), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or recorder.asked))
            state.on_exit(data)
            recorder.may_begin.set()
            self.assertTrue(wait_until(lambda: recorder.came))
            (record,) = recorder.came
        self.assertEqual(record.error_code, ErrorCode.PREEMPTED)
        self.assertEqual(record.goal_id, f"17:{state.path}#1")
        self.assertEqual((record.outcome, fake.goals), ("", []))

    def test_deleting_the_parameter_lets_behaviors_run_unrecorded(self):
        self.fakes["FixCable"].script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.says = KeepRecordResponse(False, "not now")
            state, data = self.state("FixCable"), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or recorder.came))
            rospy.delete_param(line.RECORDER_PARAMETER)
            self.assertEqual(run(state, data), "fixed")

    def test_a_state_that_is_left_while_its_record_is_not_kept_sends_it_once_more(self):
        self.fakes["RouteWire"].script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.says = KeepRecordResponse(False, "not now")
            state, data = self.state("RouteWire"), userdata()
            self.assertTrue(wait_until(lambda: state.execute(data) or recorder.came))
            came = len(recorder.came)
            state.on_exit(data)
            self.assertTrue(wait_until(lambda: len(recorder.came) > came))
            self.assertEqual({record.outcome for record in recorder.came}, {"routed"})

    def test_no_state_asks_before_the_record_of_one_that_was_left_is_kept(self):
        self.fakes["RouteWire"].script(FakeAnswer(ErrorCode.MOTION_FAULT))
        self.fakes["PlaceCable"].script(FakeAnswer())
        with self.recorder() as recorder:
            recorder.says = KeepRecordResponse(False, "not now")
            left, data = self.state("RouteWire"), userdata()
            self.assertTrue(wait_until(lambda: left.execute(data) or recorder.came))
            left.on_exit(data)
            came, asked = len(recorder.came), len(recorder.asked)
            following = self.state("PlaceCable")
            # It is sent until it is kept, however often.
            self.assertTrue(
                wait_until(lambda: following.execute(data) or len(recorder.came) > came + 6)
            )
            self.assertEqual(len(recorder.asked), asked)
            recorder.says = KeepRecordResponse(True, "")
            self.assertEqual(run(following, data), "placed")
            self.assertEqual(recorder.came[-2].error_code, ErrorCode.MOTION_FAULT)

    def test_attempts_are_counted_up_to_the_bound(self):
        state = CountAttemptsState(attempts=2)
        data = UserData()
        data["attempt"] = 0
        outcomes = [state.execute(data) for _ in range(3)]
        self.assertEqual(outcomes, ["counted", "counted", "exhausted"])

    def test_nonsense_parameters_are_refused(self):
        for make in (
            lambda: CountAttemptsState(attempts=0),
            lambda: CountAttemptsState(attempts="three"),
            lambda: self.state("PickCable", timeout_s=0.0),
            lambda: self.state("DetectCable", view=256),
            lambda: self.state("LocateGearboxComponent", view="other"),
            lambda: self.state("PickCable", timeout_s=float("nan")),
            lambda: self.state("RouteWire", path=[[0.0, 1.0]]).on_enter(userdata()),
        ):
            with self.assertRaises(ValueError):
                make()


if __name__ == "__main__":
    rospy.init_node("test_ability_states")
    rostest.rosrun("remodel_states", "test_ability_states", AbilityStatesTest)
