"""The action server that starts behaviors, if there is one."""

from __future__ import annotations

import threading
from collections.abc import Callable

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import BehaviorExecutionAction, BehaviorExecutionGoal, BEStatus
from genpy import Message

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.identity import checksum
from flexbe_testing.core.conformance.scenario import NotJudgedError, ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN, FAULT

_CANCELLED = (GoalStatus.SUCCEEDED, GoalStatus.PREEMPTED)
_NOT_DONE = (GoalStatus.REJECTED, GoalStatus.PREEMPTED, GoalStatus.ABORTED)


class _Goal:
    """One goal at the action server."""

    def __init__(self, bench: Bench, name: str, **args: str) -> None:
        """Send the goal."""
        if not bench.wire.is_subscribed(f"{topics.EXECUTE_ACTION}/goal"):
            raise NotJudgedError(f"there is no action server {topics.EXECUTE_ACTION}")
        self._bench = bench
        self._news = threading.Condition()
        self._paths: list[str] = []
        self._client = actionlib.ActionClient(topics.EXECUTE_ACTION, BehaviorExecutionAction)
        poll = rospy.Duration(0.05)
        if not bench.wire.until(lambda: self._client.wait_for_server(poll)):
            raise ViolationError(f"{topics.EXECUTE_ACTION} does not connect")
        goal = BehaviorExecutionGoal(
            behavior_name=name, arg_keys=list(args), arg_values=list(args.values())
        )
        bench.await_answer()
        self._handle = self._client.send_goal(goal, self._on_transition, self._on_feedback)

    def cancel(self) -> None:
        """Cancel the goal."""
        self._handle.cancel()

    def shows(self, path: str) -> None:
        """Expect the feedback that this state is active."""
        with self._news:
            if not self._wait(lambda: path in self._paths):
                raise ViolationError(f"feedback {self._paths}; expected: {path}")

    def ended(self, is_right: Callable[[int, str], bool], expected: str) -> None:
        """Expect an end of the goal, by its status and outcome."""
        with self._news:
            if not self._wait(self._is_done):
                raise ViolationError(f"the goal did not end within {self._bench.limit_s:g} s")
        status, result = self._handle.get_goal_status(), self._handle.get_result()
        outcome = result.outcome if result else ""
        if not is_right(status, outcome):
            raise ViolationError(f"goal status {status}, outcome {outcome!r}; expected: {expected}")

    def _wait(self, condition: Callable[[], bool]) -> bool:
        bench = self._bench
        return bench.wire.interrupt.wait_for(self._news, condition, bench.limit_s)

    def _is_done(self) -> bool:
        return self._handle.get_comm_state() == actionlib.CommState.DONE

    def _on_transition(self, handle: actionlib.ClientGoalHandle) -> None:
        with self._news:
            self._news.notify_all()

    def _on_feedback(self, handle: actionlib.ClientGoalHandle, feedback: Message) -> None:
        with self._news:
            self._paths.append(feedback.current_state)
            self._news.notify_all()


def _started(bench: Bench, name: str, module: str) -> _Goal:
    """Send a goal, and expect that the behavior starts."""
    bench.id = checksum(bench.source(module))
    goal = _Goal(bench, name)
    bench.status(BEStatus.STARTED, [])
    return goal


@scenario("A goal runs a behavior, shows its active path, and succeeds with its outcome", "3.5")
def action_succeeds(bench: Bench) -> None:
    """The path is shown if a mirror or the engine publishes it."""
    goal = _started(bench, "Conformance Chain", CHAIN)
    bench.at("/First")
    if bench.wire.publishers(topics.UPDATE):
        goal.shows("/First")
    bench.gate("First", "other")
    bench.finished("failed")
    goal.ended(
        lambda status, outcome: status == GoalStatus.SUCCEEDED and outcome == "failed",
        "SUCCEEDED (3) with 'failed'",
    )


@scenario("A goal for an unknown behavior ends without success or outcome", "3.5")
def action_unknown_behavior(bench: Bench) -> None:
    """Stock ends it with PREEMPTED; REJECTED and ABORTED are as clear."""
    goal = _Goal(bench, "No Such Behavior")
    goal.ended(
        lambda status, outcome: status in _NOT_DONE and not outcome,
        "PREEMPTED, REJECTED or ABORTED",
    )


@scenario("A cancelled goal preempts the behavior, and its outcome is `preempted`", "3.5")
def action_is_cancelled(bench: Bench) -> None:
    """Stock ends the goal with SUCCEEDED; PREEMPTED is as clear."""
    goal = _started(bench, "Conformance Chain", CHAIN)
    bench.at("/First")
    goal.cancel()
    bench.status(BEStatus.FINISHED, ["preempted"])
    goal.ended(
        lambda status, outcome: status in _CANCELLED and outcome == "preempted",
        "SUCCEEDED or PREEMPTED with 'preempted'",
    )


@scenario("A goal whose behavior cannot be built is aborted", "3.5")
def action_is_aborted(bench: Bench) -> None:
    """The engine refuses it with ERROR."""
    goal = _Goal(bench, "Conformance Fault", how="create")
    bench.status(BEStatus.ERROR, [], checksum(bench.source(FAULT)))
    goal.ended(lambda status, outcome: status == GoalStatus.ABORTED and not outcome, "ABORTED (4)")
