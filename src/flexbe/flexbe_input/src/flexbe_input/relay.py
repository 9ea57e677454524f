"""Serve flexbe/behavior_input by asking flexbe/operator_input, the operator's interface.

How goals end:

    the operator answers                            SUCCEEDED, with the operator's result
    there is no interface, or it stops              SUCCEEDED, RESULT_FAILED or RESULT_ABORTED
    the goal is cancelled                           PREEMPTED; the operator's goal is cancelled too

A client of stock FlexBE checks only the result code, so each goal ends with one.
"""

from __future__ import annotations

import threading
import time

import actionlib
import rospy
from flexbe_msgs.msg import BehaviorInputAction, BehaviorInputGoal, BehaviorInputResult

from flexbe_core.ros.master import SteadyActionServer

DEFAULT_OPERATOR_LIMIT_S = 10.0

# [s] Wall time between two checks whether the interface is still there.
_CHECK_EVERY_S = 1.0

# [s] Wall time after which an interface that has not acknowledged a question never received it.
_ACKNOWLEDGE_LIMIT_S = 5.0

# [s] Wall time after which the answer to a question that has ended was lost: an interface that
# answers while the connection of its answers is still being made.
_ANSWER_LIMIT_S = 5.0


class Relay:
    """Serves questions, any number at the same time."""

    def __init__(self, operator_limit_s: float = DEFAULT_OPERATOR_LIMIT_S) -> None:
        """Begin to serve.

        Args:
            operator_limit_s: [s] how long a question waits for an operator's interface.
        """
        self._operator_limit = rospy.Duration.from_sec(operator_limit_s)
        self._operator = actionlib.ActionClient("flexbe/operator_input", BehaviorInputAction)
        self._answered: dict[str, threading.Event] = {}
        self._server = SteadyActionServer(
            "flexbe/behavior_input",
            BehaviorInputAction,
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        self._answered[handle.get_goal_id().id] = threading.Event()
        handle.set_accepted()
        threading.Thread(target=self._relay, args=(handle,), daemon=True).start()

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        event = self._answered.get(handle.get_goal_id().id)
        if event is not None:
            event.set()

    def _relay(self, handle: actionlib.ServerGoalHandle) -> None:
        """Ask the operator and pass the answer on; runs in the thread of one question."""
        goal_id = handle.get_goal_id().id
        try:
            result, text = self._ask(handle.get_goal(), self._answered[goal_id])
            if result is None:
                handle.set_canceled(BehaviorInputResult(), "cancelled")
            else:
                handle.set_succeeded(result, text)
        finally:
            del self._answered[goal_id]

    def _ask(
        self, goal: BehaviorInputGoal, answered: threading.Event
    ) -> tuple[BehaviorInputResult | None, str]:
        """Return the operator's result and its status text; None if cancelled."""
        is_served = self._operator.wait_for_server(self._operator_limit)
        if answered.is_set():  # cancelled meanwhile
            return None, ""
        if not is_served:
            rospy.logwarn("no node serves flexbe/operator_input; a question is not answered")
            failed = BehaviorInputResult(result_code=BehaviorInputResult.RESULT_FAILED)
            return failed, "no operator's interface serves flexbe/operator_input"

        def on_transition(changed: actionlib.ClientGoalHandle) -> None:
            if changed.get_comm_state() == actionlib.CommState.DONE:
                answered.set()

        asked = self._operator.send_goal(goal, on_transition)
        asked_at = ended_at = time.monotonic()
        while not answered.wait(_CHECK_EVERY_S):
            now, state = time.monotonic(), asked.get_comm_state()
            if state != actionlib.CommState.WAITING_FOR_RESULT:
                ended_at = now
            if now - ended_at > _ANSWER_LIMIT_S:
                lost = BehaviorInputResult(result_code=BehaviorInputResult.RESULT_ABORTED)
                return lost, "the operator's interface has answered, and the answer was lost"
            is_waiting = state == actionlib.CommState.WAITING_FOR_GOAL_ACK
            is_lost = is_waiting and now - asked_at > _ACKNOWLEDGE_LIMIT_S
            limit = rospy.Duration.from_sec(_CHECK_EVERY_S)
            if is_lost or not self._operator.wait_for_server(limit):
                gone = BehaviorInputResult(result_code=BehaviorInputResult.RESULT_ABORTED)
                return gone, "the operator's interface is no longer running"
        if asked.get_comm_state() != actionlib.CommState.DONE:
            asked.cancel()
            return None, ""
        found = asked.get_result()
        if found is None:
            found = BehaviorInputResult(result_code=BehaviorInputResult.RESULT_ABORTED)
        return found, asked.get_goal_status_text()
