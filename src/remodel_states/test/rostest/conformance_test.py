#!/usr/bin/env python3
"""The conformance kit finds each bad server, for the right reason, and passes good ones."""

import json
import math
import random
import subprocess
import threading
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from remodel_msgs.msg import (
    ErrorCode,
    PlaceCableAction,
    PlaceCableActionResult,
    PlaceCableFeedback,
    PlaceCableGoal,
    PlaceCableResult,
)

from remodel_states.ability_server import AbilityServer, Done
from remodel_states.conformance.clauses import CLAUSES
from remodel_states.conformance.probe import Probe
from remodel_states.conformance.trial import Trials
from remodel_states.core.ability_error import AbilityError

DURATION_S = 0.6
SLOWER_S = 0.3  # by which a goal may take longer than the first one did
SEEDS = (0,)
CODES = {0, 1, 2, 3, 6, 400}

# What a server may do wrong, and the rule that it breaks then.
FLAWS = {
    "never answers": "no-answer",
    "answers twice": "answers-twice",
    "ends with an open status": "open-status",
    "result with another id": "wrong-id",
    "feedback with another id": "wrong-id",
    "feedback without id": "wrong-id",
    "success with a code": "success-with-code",
    "failure without a code": "failure-without-code",
    "succeeds without success": "status-against-success",
    "aborts with success": "status-against-success",
    "fails without reason": "no-reason",
    "succeeds with a reason": "reason-of-success",
    "unknown code": "unknown-code",
    "negative time": "wrong-time",
    "time is not a number": "wrong-time",
    "time in milliseconds": "wrong-time",
    "more than 100 %": "percentage-range",
    "less than 0 %": "percentage-range",
    "percentage is not a number": "percentage-range",
    "progress goes back": "percentage-falls",
    "feedback time goes back": "feedback-time",
    "feedback after the end": "feedback-after-end",
    "no feedback": "no-feedback",
    "ignores its timeout": "timeout-ignored",
    "ends at its timeout with another code": "timeout-code",
    "ignores a cancel": "cancel-status",
    "cancels slowly": "slow-cancel",
    "cancelled with another code": "cancel-code",
    "aborts when cancelled": "cancel-status",
    "applies any cancel": "foreign-cancel",
    "loses the second goal": "no-answer",
    "mixes up two goals": "wrong-id",
    "takes NaN": "accepts-invalid-goal",
    "takes any timeout": "accepts-invalid-goal",
    "takes no id": "accepts-invalid-goal",
    "dies of NaN": "no-answer",
    "refuses with another code": "invalid-goal-code",
    "refuses without naming the field": "invalid-goal-unnamed",
    "places cables that do not exist": "accepts-unknown-name",
}

# Servers that break no clause, but with which a trial says nothing, why it does not, and the
# command that restarts them.
UNJUDGED = (
    (
        "knows no timeout",
        "slow",
        {
            "a timeout shorter than the ability takes": "a server that ignores timeouts does the "
            "same",
            "a goal with an unknown name": "empty in the goal: robot_name",
            "restart of the server": "no command given",
        },
        "",
    ),
    (
        "",
        "late",
        {"the goal that ran during the restart": "ended before the server was restarted"},
        f"sleep {2 * DURATION_S}",
    ),
    (
        "is quick",
        "quick",
        {
            "feedback while the ability works": "only one that takes longer than 1 s",
            "a cancel of a goal that was never sent": "at least 0.3 s",
            "a timeout shorter than the ability takes": "at least 0.3 s",
            "a cancel while the ability works": "at least 0.3 s",
            "a second goal while the first is done": "at least 0.3 s",
        },
        "",
    ),
    (
        "is slow only once",
        "once",
        {
            "a cancel of a goal that was never sent": "ended before the cancel",
            "a timeout shorter than the ability takes": "succeeded after",
            "a cancel while the ability works": "ended before the cancel",
            "a second goal while the first is done": "ended before the second one",
        },
        "",
    ),
    (
        "fails before its timeout",
        "failing",
        {"a timeout shorter than the ability takes": "failed before its timeout of"},
        "",
    ),
)


class Server:
    """A good ability server, but for one flaw."""

    def __init__(self, topic, flaw="", seed=0):
        self.flaw = flaw
        self.random = random.Random(seed)
        self.duration_s = DURATION_S + self.random.uniform(0.0, 0.3)
        if flaw == "no feedback":
            self.duration_s += 0.7
        self.goals = self.cancels = 0
        self.refused = 0
        self.restart_is_next = False  # after the trial of unknown names
        self.working = None
        self.cancelled = set()
        self.server = actionlib.ActionServer(
            topic, PlaceCableAction, self.on_goal, self.on_cancel, auto_start=False
        )
        self.server.start()
        self.has = lambda flaw: flaw == self.flaw
        if flaw == "applies any cancel":
            rospy.Subscriber(f"{topic}/cancel", actionlib.GoalID, self.on_any_cancel)

    def on_any_cancel(self, message):
        if self.working is not None:
            self.cancelled.add(self.working)

    def on_cancel(self, handle):
        if not self.has("ignores a cancel"):
            self.cancelled.add(handle.get_goal_id().id)

    def on_goal(self, handle):
        goal = handle.get_goal()
        field, found = self.invalid_field(goal)
        if field:
            code = 400 if self.has("refuses with another code") else ErrorCode.INVALID_GOAL
            name = "something" if self.has("refuses without naming the field") else field
            self.reject(handle, code, f"{name} is {found}")
        elif goal.cable_id != "W1" and not self.has("places cables that do not exist"):
            self.restart_is_next = True
            self.reject(handle, 400, f"there is no cable {goal.cable_id!r}; there is W1")
        elif self.working is not None and not self.has("mixes up two goals"):
            self.refused += 1
            if not self.has("loses the second goal"):
                self.reject(handle, 6, "the arm is doing another goal")
        else:
            handle.set_accepted()
            self.goals += 1
            self.refused = 0  # while it works on this one
            if self.has("is quick"):
                self.duration_s = 0.03
            elif self.has("is slow only once"):
                # By far: later ones have ended before what the kit does after a third of the first.
                self.duration_s = 1.5 if self.goals == 1 else 0.03
            self.working = handle.get_goal_id().id
            self.last_id = goal.id
            threading.Thread(target=self.work, args=[handle], daemon=True).start()

    def invalid_field(self, goal):
        if not goal.id and not self.has("takes no id"):
            return "id", "empty"
        if not (0 < goal.timeout < math.inf) and not self.has("takes any timeout"):
            return "timeout", goal.timeout
        position = goal.target_pose.pose.position
        if math.isnan(position.x + position.y + position.z):
            if self.has("dies of NaN"):
                raise ValueError("NaN")
            return ("", 0) if self.has("takes NaN") else ("target_pose", "NaN")
        return "", 0

    def reject(self, handle, code, text):
        goal = handle.get_goal()
        handle.set_rejected(
            PlaceCableResult(id=goal.id, error_code=code, error_message=text),
            text,
        )

    def work(self, handle):
        end = self.end_of(handle)
        # Before the answer is out: the next goal may follow at once.
        self.working = None
        end()

    def end_of(self, handle):
        """Do a goal, and return how it ends."""
        goal, goal_id = handle.get_goal(), handle.get_goal_id().id
        begin = time.monotonic()
        while True:
            took = time.monotonic() - begin
            if not (self.has("no feedback") or self.has("is quick")):
                handle.publish_feedback(self.feedback(goal, took))
            if goal_id in self.cancelled:
                return lambda: self.end_cancelled(handle, goal, took)
            ignores = self.has("ignores its timeout") or self.has("knows no timeout")
            if self.has("fails before its timeout") and goal.timeout < DURATION_S:
                return lambda: self.abort(handle, goal, took, 400, "the cable slipped")
            if took > goal.timeout and not ignores:
                code = 400 if self.has("ends at its timeout with another code") else 1
                return lambda: self.abort(handle, goal, took, code, "out of time")
            limit_s = self.duration_s
            if self.has("ignores its timeout") and goal.timeout < DURATION_S:
                limit_s = goal.timeout + 3.0
            if took > limit_s and not self.works_on(took):
                return lambda: self.end(handle, goal, took)
            time.sleep(0.05)

    def works_on(self, took):
        """Return whether the goal that runs during the restart goes on until after the next one."""
        if not (self.has("goes on when it is restarted") and self.restart_is_next):
            return False
        return not self.refused or took < self.duration_s + SLOWER_S

    def abort(self, handle, goal, took, code, text):
        result = PlaceCableResult(
            id=goal.id, elapsed_time=took, error_code=code, error_message=text
        )
        handle.set_aborted(result, text)

    def end_cancelled(self, handle, goal, took):
        self.cancels += 1
        if self.has("cancels slowly") or (self.has("cancels slowly at first") and self.cancels < 3):
            time.sleep(0.7 + self.random.random())
        code = 400 if self.has("cancelled with another code") else ErrorCode.PREEMPTED
        result = PlaceCableResult(
            id=goal.id, elapsed_time=took, error_code=code, error_message="cancelled"
        )
        if self.has("aborts when cancelled"):
            handle.set_aborted(result, "cancelled")
        else:
            handle.set_canceled(result, "cancelled")

    def feedback(self, goal, took):
        share = min(100.0, 100.0 * took / self.duration_s)
        wrong = self.random.uniform(1.0, 20.0)
        if self.has("progress goes back"):
            share = 100.0 - share
        elif self.has("more than 100 %"):
            share += 100.0 + wrong
        elif self.has("less than 0 %"):
            share = -wrong
        elif self.has("percentage is not a number"):
            share = math.nan
        elapsed = DURATION_S - took if self.has("feedback time goes back") else took
        name = {"feedback with another id": "G0", "feedback without id": ""}.get(self.flaw, goal.id)
        return PlaceCableFeedback(name, "placing", max(0.0, elapsed), share)

    def end(self, handle, goal, took):
        if self.has("never answers"):
            return
        result = PlaceCableResult(id=goal.id, success=True, message="placed", elapsed_time=took)
        if self.has("result with another id"):
            result.id = f"G{self.random.randrange(1000)}"
        elif self.has("mixes up two goals"):
            result.id = self.last_id
        elif self.has("success with a code"):
            result.error_code = 400
        elif self.has("negative time"):
            result.elapsed_time = -took
        elif self.has("time is not a number"):
            result.elapsed_time = math.nan
        elif self.has("time in milliseconds"):
            result.elapsed_time = 1000.0 * took
        elif self.has("succeeds without success"):
            result.success, result.error_code, result.error_message = False, 400, "no"
        elif self.has("succeeds with a reason"):
            result.error_message = "it went well"
        if self.has("ends with an open status"):
            status = handle.get_goal_status()
            status.status = GoalStatus.ACTIVE
            self.server.result_pub.publish(PlaceCableActionResult(status=status, result=result))
            return
        if self.has("aborts with success"):
            handle.set_aborted(result, "")
            return
        code = {"failure without a code": 0, "fails without reason": 400}.get(self.flaw)
        if code is not None or self.has("unknown code"):
            code = self.random.randrange(900, 999) if code is None else code
            text = "" if self.has("fails without reason") else "no"
            self.abort(handle, goal, took, code, text)
            return
        handle.set_succeeded(result)
        if self.has("answers twice"):
            status = handle.get_goal_status()
            again = PlaceCableActionResult(status=status, result=result)
            self.server.result_pub.publish(again)
        if self.has("feedback after the end"):
            time.sleep(0.5)
            handle.publish_feedback(self.feedback(goal, took))


class Placing(AbilityServer):
    """The base of servers, with as little as a subclass needs."""

    def check(self, goal):
        if goal.cable_id != "W1":
            raise AbilityError(ErrorCode.UNKNOWN_NAME, f"no cable {goal.cable_id!r}; there is W1")

    def perform(self, running):
        if running.goal.robot_name == "broken":
            raise ValueError("a mistake of the subclass")
        running.report("placing", 10.0)
        running.wait(DURATION_S)
        return Done("placed")


def good_goal():
    goal = PlaceCableGoal(id="good", cable_id="W1", timeout=3.0, target_pose=PoseStamped())
    goal.target_pose.pose.orientation.w = 1.0
    return goal


def trials_of(flaw, name, seed=0, **options):
    """Return the trials of a server with this flaw."""
    topic = f"conformance/{name}"
    server = Server(topic, flaw, seed)
    probe = Probe(topic, PlaceCableAction)
    trials = list(Trials(probe, good_goal(), CODES, **options).run())
    probe.close()
    del server
    return trials


def broken_rules(flaw, seed):
    """Return the rules that a server with this flaw breaks."""
    trials = trials_of(flaw, f"flaw_{abs(hash((flaw, seed)))}", seed)
    return {fault.rule for trial in trials for fault in trial.faults}


class ConformanceTest(unittest.TestCase):
    def test_each_bad_server_is_found(self):
        tried = [(flaw, seed) for flaw in FLAWS for seed in SEEDS]
        self.assertGreaterEqual(len(tried), 20)
        with ThreadPoolExecutor(16) as pool:
            found = list(pool.map(lambda flaw: broken_rules(*flaw), tried))
        missed = {
            flaw: broken
            for flaw, broken in zip(tried, found, strict=True)
            if FLAWS[flaw[0]] not in broken
        }
        self.assertEqual(missed, {})

    def test_each_clause_is_broken_by_a_bad_server(self):
        broken_by_restarts = {"not-back", "ghost"}
        self.assertEqual(set(FLAWS.values()) | broken_by_restarts, set(CLAUSES))

    def test_a_restart_that_does_not_restart_is_found(self):
        trials = trials_of("goes on when it is restarted", "restart", restart="true")
        faults = [fault.rule for trial in trials for fault in trial.faults]
        self.assertIn("ghost", faults)

    def test_good_servers_pass(self):
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(lambda seed: broken_rules("", seed), range(4)))
        self.assertEqual(found, [set()] * 4)

    def test_a_cancel_that_a_busy_machine_delays_is_tried_again(self):
        self.assertEqual(broken_rules("cancels slowly at first", 0), set())

    def test_what_could_not_be_tried_is_not_judged(self):
        """Each server is without fault, and each reason says what would be needed."""
        with ThreadPoolExecutor(5) as pool:
            tried = list(
                pool.map(
                    lambda row: trials_of(row[0], f"unjudged_{row[1]}", restart=row[3]), UNJUDGED
                )
            )
        for trials, (flaw, _, expected, _) in zip(tried, UNJUDGED, strict=True):
            self.assertEqual([fault for trial in trials for fault in trial.faults], [], flaw)
            unjudged = {trial.name: trial.unjudged for trial in trials if trial.unjudged}
            for name, reason in expected.items():
                self.assertIn(reason, unjudged.get(name, f"was judged: {unjudged}"), flaw)

    def test_the_base_of_servers_keeps_the_contract(self):
        topic = "conformance/base"
        server = Placing("PlaceCable", topic=topic)
        probe = Probe(topic, PlaceCableAction)
        found = list(Trials(probe, good_goal(), CODES).run())
        probe.close()
        self.assertEqual([fault for trial in found for fault in trial.faults], [])
        self.assertGreater(len(found), 10)
        self.assertEqual(server.ability.name, "PlaceCable")

    def test_the_base_of_servers_refuses_an_older_supervisor_and_survives_a_mistake(self):
        topic = "conformance/owners"
        server = Placing("PlaceCable", topic=topic)
        client = actionlib.SimpleActionClient(topic, PlaceCableAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(60.0)))
        codes = []
        for owner, robot in (("2:", ""), ("1:", ""), ("2:", "broken"), ("2:", "")):
            goal = good_goal()
            goal.id, goal.robot_name = f"{owner}good", robot
            client.send_goal_and_wait(goal, rospy.Duration(60.0))
            codes.append(client.get_result().error_code)
        stale, internal = ErrorCode.STALE_OWNER, ErrorCode.INTERNAL
        self.assertEqual(codes, [0, stale, internal, 0])
        self.assertEqual(server.ability.name, "PlaceCable")

    def run_kit(self, *words):
        line = ["rosrun", "remodel_states", "conformance", *words]
        return subprocess.run(line, capture_output=True, text=True, timeout=400.0)

    def test_the_command_prints_and_exits_by_it(self):
        server = Server("conformance/bad", "success with a code")
        goal = "{cable_id: W1, timeout: 3, target_pose: {pose: {orientation: {w: 1}}}}"
        done = self.run_kit("conformance/bad", "PlaceCable", "--goal", goal)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn(
            "BROKEN      a goal that can be done\n            [success-with-code]", done.stdout
        )
        server.flaw = ""
        done = self.run_kit("conformance/bad", "PlaceCable", "--goal", goal, "--json")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertGreater(len(json.loads(done.stdout)["trials"]), 10)

    def test_a_restarted_server_is_tried_again(self):
        words = ("remodel_abilities/placepin", "PlacePin", "--restart")
        done = self.run_kit(*words, "rosnode kill /fakes")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("ok          restart of the server", done.stdout)
        done = self.run_kit(*words, "false")
        self.assertIn("not judged  restart of the server: the command failed with 1", done.stdout)

    def test_what_cannot_be_tried_is_reported(self):
        for words, message in (
            (("conformance/none", "PlaceCable"), "start the server"),
            (
                ("conformance/none", "Nonesuch"),
                "no action remodel_msgs/Nonesuch; give one of another package as package/Name",
            ),
            (("conformance/none", "PlaceCable", "--goal", "{cable: W1}"), "cable"),
            (("conformance/none", "PlaceCable", "--goal", "[1"), "cannot read the goal"),
        ):
            done = self.run_kit(*words)
            self.assertEqual(done.returncode, 2, (words, done.stdout))
            self.assertIn(message, done.stderr)


if __name__ == "__main__":
    rospy.init_node("test_conformance")
    rostest.rosrun("remodel_states", "test_conformance", ConformanceTest)
