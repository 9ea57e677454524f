"""A synthesis server as the console sees it: a request, then the states or the reason why not."""

from __future__ import annotations

import time

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisGoal,
    BehaviorSynthesisResult,
    StateInstantiation,
    SynthesisRequest,
)

from flexbe_core.ros.connections import senders
from flexbe_synthesizer.core.export.instantiate import Instantiation
from remodel_console.core.editor.inspection import ServerRequest
from remodel_console.errors import CommandError

_FOUND_S = 5.0  # in which a server is found; wall time, as a person waits
_ANSWER_S = 65.0  # longer than our own server takes at most
_LOST_S = 1.0  # after the end of a goal, in which its result comes if it does at all
_POLL_S = 0.05


def ask_synthesis_server(request: ServerRequest) -> tuple[Instantiation, ...]:
    """Return the states that a server makes for a request.

    Raises:
        CommandError: if there is no server, or it fails, or gives no answer in time.
    """
    client = actionlib.ActionClient(request.topic, BehaviorSynthesisAction)
    try:
        _wait_for(client, request.topic)
        return _result(client, request)
    finally:
        client.stop()


def _wait_for(client: actionlib.ActionClient, topic: str) -> None:
    end_s = time.monotonic() + _FOUND_S
    while not (client.pub_goal.get_num_connections() and senders(client.result_sub)):
        if rospy.is_shutdown() or time.monotonic() > end_s:
            raise CommandError(
                f"no synthesis server serves {rospy.resolve_name(topic)}; start it: roslaunch "
                "flexbe_synthesizer synthesizer.launch, or leave the action topic empty on the "
                "Configuration page: then the console itself synthesizes"
            )
        time.sleep(_POLL_S)


def _result(client: actionlib.ActionClient, request: ServerRequest) -> tuple[Instantiation, ...]:
    goal = BehaviorSynthesisGoal(
        SynthesisRequest(
            name=request.path,
            system=request.system,
            goal=request.goal,
            initial_condition=request.initial,
        )
    )
    status = [""]

    def on_feedback(_: actionlib.ClientGoalHandle, feedback: BehaviorSynthesisFeedback) -> None:
        status[0] = feedback.status

    end_s = time.monotonic() + _ANSWER_S
    handle = client.send_goal(goal, feedback_cb=on_feedback)
    while not _has_result(handle, end_s):
        handle = client.send_goal(goal, feedback_cb=on_feedback)
    result: BehaviorSynthesisResult | None = handle.get_result()
    if handle.get_goal_status() != GoalStatus.SUCCEEDED or result is None:
        reason = handle.get_goal_status_text() or status[0] or "it gave no reason"
        raise CommandError(f"the synthesis server refuses: {reason}")
    return tuple(map(_instantiation, result.states))


def _has_result(handle: actionlib.ClientGoalHandle, end_s: float) -> bool:
    """Wait until a goal has ended, and return whether its result has come.

    A server that has just been connected may send a result before it knows that we listen.

    Raises:
        CommandError: if it has not ended at a wall time [s].
    """
    since_s = time.monotonic()  # since when only the result is missing
    while (state := handle.get_comm_state()) != actionlib.CommState.DONE:
        now_s = time.monotonic()
        if now_s > end_s:
            handle.cancel()
            raise CommandError(f"the synthesis server has not answered within {_ANSWER_S:.0f} s")
        if state != actionlib.CommState.WAITING_FOR_RESULT:
            since_s = now_s
        elif now_s - since_s > _LOST_S:
            return False
        time.sleep(_POLL_S)
    return True


def _instantiation(state: StateInstantiation) -> Instantiation:
    conditions = (
        tuple(zip(c.state_name, c.state_outcome, strict=True)) for c in state.cond_transition
    )
    return Instantiation(
        state_path=state.state_path,
        state_class=state.state_class,
        initial_state_name=state.initial_state_name,
        input_keys=tuple(state.input_keys),
        output_keys=tuple(state.output_keys),
        cond_outcome=tuple(state.cond_outcome),
        cond_transition=tuple(conditions),
        behavior_class=state.behavior_class,
        parameter_names=tuple(state.parameter_names),
        parameter_values=tuple(state.parameter_values),
        outcomes=tuple(state.outcomes),
        transitions=tuple(state.transitions),
        autonomy=tuple(state.autonomy),
        userdata_keys=tuple(state.userdata_keys),
        userdata_remapping=tuple(state.userdata_remapping),
    )
