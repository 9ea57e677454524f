#!/usr/bin/env python3
"""InputState asks, the node passes it on, the operator answers."""

import threading
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import BehaviorInputAction, BehaviorInputGoal, BehaviorInputResult

from flexbe_core import OperatableStateMachine
from flexbe_core.engine.supervision import Preempt
from flexbe_core.ros.session import own_session
from flexbe_core.testing import wait_until
from flexbe_states.input_state import InputState

LIMIT_S = 90.0


class Silence:
    """A publisher to which nobody is connected."""

    def publish(self, *_):
        pass

    def get_num_connections(self):
        return 1


class Operator:
    """An operator's interface that answers as the test says; None leaves the question open."""

    def __init__(self, code, data):
        self.goals, self.cancelled = [], threading.Event()
        self.on_goal = lambda: None
        self._answer = None if code is None else BehaviorInputResult(code, data)
        self._server = actionlib.ActionServer(
            "flexbe/operator_input",
            BehaviorInputAction,
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()
        self._result_pub = self._server.result_pub

    def _on_goal(self, handle):
        self.goals.append(handle.get_goal())
        handle.set_accepted()
        self.on_goal()
        if self._answer is not None:
            # An answer to a connection that is still being made is lost.
            wait_until(lambda: self._server.result_pub.get_num_connections() > 0)
            handle.set_succeeded(self._answer)

    def lose_answers(self):
        self._server.result_pub = Silence()

    def _on_cancel(self, handle):
        handle.set_canceled()
        self.cancelled.set()

    def close(self):
        for topic in (self._server.goal_sub, self._server.cancel_sub, self._server.status_pub):
            topic.unregister()
        self._result_pub.unregister()
        self._server.feedback_pub.unregister()


class InputTest(unittest.TestCase):
    def setUp(self):
        state = InputState(3, "Which pin?")
        self.machine = OperatableStateMachine(outcomes=[f"it {name}" for name in state.outcomes])
        self.machine.autonomy_level = 255
        with self.machine:
            OperatableStateMachine.add(
                "Ask", state, {name: f"it {name}" for name in state.outcomes}
            )

    def ask(self, code, data=""):
        """Return the outcome, the value, and what the operator was asked."""
        operator = Operator(code, data)
        try:
            outcome = self.machine.spin()
            return outcome, self.machine._userdata["data"], operator.goals
        finally:
            operator.close()

    def test_an_answer_is_read_as_a_literal(self):
        outcome, data, goals = self.ask(BehaviorInputResult.RESULT_OK, "{'pin': [7, 1.5]}")
        self.assertEqual((outcome, data), ("it received", {"pin": [7, 1.5]}))
        self.assertEqual((goals[0].request_type, goals[0].msg), (3, "Which pin?"))

    def test_an_answer_that_is_no_literal_is_an_error(self):
        outcome, data, _ = self.ask(BehaviorInputResult.RESULT_OK, "__import__('os')")
        self.assertEqual((outcome, data), ("it data_error", None))

    def test_an_operator_may_refuse(self):
        outcome, data, _ = self.ask(BehaviorInputResult.RESULT_ABORTED)
        self.assertEqual((outcome, data), ("it aborted", None))

    def test_a_question_whose_answer_is_lost_ends(self):
        operator = Operator(BehaviorInputResult.RESULT_OK, "7")
        try:
            operator.lose_answers()
            self.assertEqual(self.machine.spin(), "it aborted")
            self.assertEqual(len(operator.goals), 1)
        finally:
            operator.close()

    def test_without_an_interface_no_request_waits_forever(self):
        self.assertEqual(self.machine.spin(), "it aborted")

    def test_a_question_that_is_stopped_is_cancelled_at_the_operator(self):
        operator = Operator(None, "")
        try:
            operator.on_goal = lambda: own_session(self.machine).post(Preempt())
            self.assertEqual(self.machine.spin(), "preempted")
            self.assertTrue(operator.cancelled.wait(LIMIT_S))
        finally:
            operator.close()

    def test_a_question_that_is_cancelled_before_there_is_an_interface_is_not_shown(self):
        client = actionlib.ActionClient("flexbe/behavior_input", BehaviorInputAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(LIMIT_S)))
        asked = client.send_goal(BehaviorInputGoal(3, "Which pin?"))
        state = actionlib.CommState
        wait_until(lambda: asked.get_comm_state() == state.ACTIVE)
        asked.cancel()
        wait_until(lambda: asked.get_comm_state() in (state.PREEMPTING, state.DONE))
        operator = Operator(BehaviorInputResult.RESULT_OK, "7")
        try:
            wait_until(lambda: asked.get_comm_state() == state.DONE)
            self.assertEqual(asked.get_goal_status(), GoalStatus.PREEMPTED)
            self.assertEqual(operator.goals, [])
        finally:
            operator.close()


if __name__ == "__main__":
    rospy.init_node("test_input")
    rostest.rosrun("flexbe_input", "test_input", InputTest)
