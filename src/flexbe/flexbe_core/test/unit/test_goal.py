"""A goal as its client knows it."""

import sys
import threading
import weakref

from actionlib_msgs.msg import GoalStatus, GoalStatusArray

from flexbe_core.proxy.proxy_action_client import UNNOTICED_S, ActionConnection, Goal
from flexbe_core.ros.driver import Waiting


def status(code, text=""):
    return GoalStatus(status=code, text=text)


def test_a_goal_is_pending_then_active_then_answered():
    goal = Goal("1")
    assert (goal.simple_status, goal.is_active) == (GoalStatus.PENDING, True)
    assert goal.take_status(status(GoalStatus.ACTIVE, "go"))
    assert (goal.status, goal.text) == (GoalStatus.ACTIVE, "go")
    goal.take_result(status(GoalStatus.SUCCEEDED, "well"), "result")
    assert (goal.status, goal.text, goal.result) == (GoalStatus.SUCCEEDED, "well", "result")
    assert not goal.is_active


def test_a_goal_that_the_server_does_not_know_yet_is_waited_for():
    goal = Goal("1")
    assert not goal.take_status(None)
    assert goal.is_active


def test_a_goal_that_the_server_never_lists_is_lost():
    goal = Goal("1", sent_at=10.0)
    assert not goal.take_status(None, 10.0 + 0.9 * UNNOTICED_S)
    assert goal.take_status(None, 10.0 + UNNOTICED_S)
    assert (goal.status, goal.text) == (GoalStatus.LOST, "the server never received the goal")


def test_a_goal_that_the_server_knew_and_forgot_is_lost():
    goal = Goal("1")
    goal.take_status(status(GoalStatus.ACTIVE))
    assert goal.take_status(None)
    assert (goal.status, goal.is_active) == (GoalStatus.LOST, False)


def test_a_terminal_status_waits_for_its_result():
    goal = Goal("1")
    goal.take_status(status(GoalStatus.ACTIVE))
    assert not goal.take_status(status(GoalStatus.SUCCEEDED))
    assert goal.is_active


def test_what_comes_after_the_end_is_ignored():
    goal = Goal("1")
    goal.take_result(status(GoalStatus.ABORTED), "result")
    assert not goal.take_status(None)
    assert goal.status == GoalStatus.ABORTED


def test_states_between_look_as_to_a_simple_client():
    goal = Goal("1")
    goal.take_status(status(GoalStatus.PREEMPTING))
    assert goal.simple_status == GoalStatus.ACTIVE
    goal = Goal("2")
    goal.take_status(status(GoalStatus.RECALLING))
    assert goal.simple_status == GoalStatus.PENDING


def test_goals_may_be_sent_while_a_status_is_taken():
    connection = ActionConnection.__new__(ActionConnection)
    goals = [Goal("first"), Goal("second")]
    connection._goals = weakref.WeakValueDictionary({goal.goal_id: goal for goal in goals})
    connection._changed, connection.for_status = threading.Event(), Waiting()

    def send_another(frame, event, arg):
        """Act as another thread that runs between two lines of the list of goals."""
        if event == "line" and frame.f_code.co_filename == weakref.__file__ and len(goals) < 9:
            goals.append(Goal(f"{len(goals)}"))
            connection._goals[goals[-1].goal_id] = goals[-1]
        return send_another

    before = sys.gettrace()
    sys.settrace(send_another)
    try:
        connection._on_status(GoalStatusArray())
    finally:
        sys.settrace(before)
    assert len(goals) > 2
