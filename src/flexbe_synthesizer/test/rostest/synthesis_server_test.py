#!/usr/bin/env python3
import threading
import unittest
from pathlib import Path

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisActionFeedback,
    BehaviorSynthesisGoal,
    StateInstantiation,
    SynthesisErrorCodes,
    SynthesisRequest,
)

from flexbe_core.testing import is_sent_to, wait_until
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Behavior, Chart, Input, Outcome, Transition
from flexbe_synthesizer.synthesis import ErrorCode

LIMIT = rospy.Duration(90)


class SynthesisServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Subscribe to the feedback; an action client drops it if the result overtakes it."""
        cls.feedback = []
        cls.subscriber = rospy.Subscriber(
            "flexbe/synthesize/feedback", BehaviorSynthesisActionFeedback, cls.feedback.append
        )

    def setUp(self):
        self.client = self.new_client()
        self.assertTrue(wait_until(lambda: is_sent_to(self.subscriber)))

    def new_client(self):
        client = actionlib.ActionClient("flexbe/synthesize", BehaviorSynthesisAction)
        self.assertTrue(client.wait_for_server(LIMIT))
        return client

    def send(self, goal, initial="start", outcomes=(), client=None):
        """Send a request; return its handle and an event for its end."""
        done = threading.Event()

        def on_transition(handle):
            if handle.get_comm_state() == actionlib.CommState.DONE:
                done.set()

        request = SynthesisRequest("/Task", "", goal, initial, list(outcomes))
        handle = (client or self.client).send_goal(BehaviorSynthesisGoal(request), on_transition)
        return handle, done

    def feedback_of(self, handle):
        """Return what has arrived of the feedback on a request."""
        goal_id = handle.comm_state_machine.action_goal.goal_id.id
        return [
            message.feedback for message in self.feedback if message.status.goal_id.id == goal_id
        ]

    def ask(self, *arguments):
        """Send a request; return its handle and its feedback once all of both has arrived."""
        handle, done = self.send(*arguments)
        self.assertTrue(done.wait(LIMIT.to_sec()))
        self.assertTrue(
            wait_until(lambda: any(message.progress == 1.0 for message in self.feedback_of(handle)))
        )
        return handle, self.feedback_of(handle)

    def refuse(self, code, *arguments):
        handle, feedback = self.ask(*arguments)
        self.assertEqual(handle.get_goal_status(), GoalStatus.ABORTED)
        self.assertEqual(handle.get_result().error_code.value, code)
        self.assertEqual(handle.get_result().states, [])
        text = handle.get_goal_status_text()
        self.assertEqual(feedback[-1].status, text)
        return text

    def test_a_chart_becomes_states_and_files(self):
        handle, feedback = self.ask("place_connector.xml", "start", ["finished", "failed"])
        self.assertEqual(handle.get_goal_status(), GoalStatus.SUCCEEDED)
        result = handle.get_result()
        self.assertEqual(result.error_code.value, SynthesisErrorCodes.SUCCESS)
        by_path = {state.state_path: state for state in result.states}
        self.assertEqual(by_path["/"].state_class, StateInstantiation.CLASS_STATEMACHINE)
        fix = by_path["/Fix"]
        self.assertEqual(fix.state_class, StateInstantiation.CLASS_CONCURRENCY)
        self.assertEqual(fix.cond_transition[2].state_name, ["timer"])
        self.assertEqual(fix.cond_transition[2].state_outcome, ["done"])
        output = Path(rospy.get_param("synthesis_server/output"))
        self.assertTrue((output / "manifest" / "place_connector.xml").is_file())
        code = output / "src" / output.name / "place_connector_sm.py"
        compile(code.read_text(), str(code), "exec")
        self.assertEqual([f.progress for f in feedback], sorted(f.progress for f in feedback))

    def test_each_way_to_fail_has_its_code_and_its_reason(self):
        text = self.refuse(ErrorCode.CHART_INVALID, "ten_mistakes.xml")
        self.assertEqual(len(text.splitlines()), 10)
        self.assertIn("no chart 'none.xml'", self.refuse(ErrorCode.CHART_NOT_FOUND, "none.xml"))
        self.assertIn("outside", self.refuse(ErrorCode.CHART_REFUSED, "../../package.xml"))
        self.assertIn("outside", self.refuse(ErrorCode.CHART_REFUSED, "/etc/passwd"))
        self.assertIn("'Lokate'", self.refuse(ErrorCode.INITIAL_UNKNOWN, "plain.xml", "Lokate"))
        text = self.refuse(ErrorCode.OUTCOMES_DIFFER, "plain.xml", "", ["finished"])
        self.assertIn("'PlacePin finished normally'", text)

    def test_a_file_in_the_way_is_reported_and_the_server_lives_on(self):
        output = Path(rospy.get_param("synthesis_server/output"))
        blocked = output / "src" / output.name / "plain_chart_sm.py"
        blocked.parent.mkdir(parents=True, exist_ok=True)
        blocked.write_text("by hand\n")
        self.assertIn("written by hand", self.refuse(ErrorCode.OUTPUT_FAILED, "plain.xml"))
        self.assertEqual(blocked.read_text(), "by hand\n")
        blocked.unlink()
        self.assertEqual(self.ask("plain.xml")[0].get_goal_status(), GoalStatus.SUCCEEDED)

    def test_requests_are_served_one_after_another(self):
        clients = [self.client, self.new_client()]
        sent = [self.send("wire_task.xml", client=clients[i % 2]) for i in range(6)]
        for _, done in sent:
            self.assertTrue(done.wait(LIMIT.to_sec()))
        self.assertEqual({handle.get_goal_status() for handle, _ in sent}, {GoalStatus.SUCCEEDED})
        lists = [handle.get_result().states for handle, _ in sent]
        self.assertTrue(all(states == lists[0] for states in lists))

    def test_a_request_can_be_cancelled_while_it_is_served_and_while_it_waits(self):
        folder = Path(rospy.get_param("synthesis_server/chart_folders").rpartition(":")[2])
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "long.xml").write_text(write_chart(long_chart(12000)))
        served, served_done = self.send("long.xml")
        waiting, waiting_done = self.send("plain.xml")
        self.assertTrue(wait_until(lambda: self.feedback_of(served)))
        self.assertTrue(wait_until(lambda: waiting.get_comm_state() == actionlib.CommState.PENDING))
        waiting.cancel()
        served.cancel()
        for handle, done, end in (
            (waiting, waiting_done, GoalStatus.RECALLED),
            (served, served_done, GoalStatus.PREEMPTED),
        ):
            self.assertTrue(done.wait(LIMIT.to_sec()))
            self.assertEqual(handle.get_goal_status(), end)
            self.assertEqual(handle.get_result().error_code.value, ErrorCode.CANCELLED)
        output = Path(rospy.get_param("synthesis_server/output"))
        self.assertFalse((output / "manifest" / "long.xml").exists())


def long_chart(count):
    """Return a chart that takes a second, so that a cancel comes while it is served."""
    nodes = tuple(
        Behavior(
            f"B{i}",
            "Clean Up",
            (
                Transition("cleaned", f"B{i + 1}" if i < count - 1 else "done"),
                Transition("failed", "done"),
            ),
        )
        for i in range(count)
    )
    return Chart("Long", "B0", (Outcome("done"),), nodes, inputs=(Input("cable_id"),))


if __name__ == "__main__":
    rospy.init_node("test_synthesis_server")
    rostest.rosrun("flexbe_synthesizer", "test_synthesis_server", SynthesisServerTest)
