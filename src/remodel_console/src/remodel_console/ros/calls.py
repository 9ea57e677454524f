"""Services called with a limit to the wait, and requests to a synthesis server."""

from __future__ import annotations

import threading
import time
from dataclasses import fields
from typing import Any

import actionlib
import rosgraph
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisGoal,
    BehaviorSynthesisResult,
    StateInstantiation,
    SynthesisRequest,
    UICommand,
)
from genpy import Message
from std_msgs.msg import String

from flexbe_core.ros.master import senders
from flexbe_synthesizer.core.export.layout import Instantiation
from remodel_console.core.commands import CommandResult, read_answer, trouble_words
from remodel_console.core.server_states import ServerRequest
from remodel_console.errors import CommandError
from remodel_console.ros import topics

LIMIT_S = 8.0  # wall time


def call_service(name: str, kind: type, request: Message, limit_s: float = LIMIT_S) -> Any:  # noqa: ANN401 - rospy's answers have no common type
    """Return the answer of a service.

    Args:
        name: of the service.
        kind: its class.
        request: to it.
        limit_s: wall time in which it answers [s]; the service itself must be there earlier.

    Raises:
        CommandError: if no node serves it, it fails, or it does not answer in time.
    """
    answers: list[Message] = []
    mistakes: list[Exception] = []

    def call() -> None:
        try:
            rospy.wait_for_service(name, timeout=min(limit_s, LIMIT_S))
            answers.append(rospy.ServiceProxy(name, kind)(request))
        except (rospy.ROSException, rospy.ServiceException) as error:
            mistakes.append(error)

    calling = threading.Thread(target=call, name=f"call {name}", daemon=True)
    calling.start()
    calling.join(limit_s)
    if answers:
        return answers[0]
    reason = str(mistakes[0]) if mistakes else ""
    raise CommandError(trouble_words(rospy.resolve_name(name), reason, limit_s))


# [s] Wall time in which a console that is starting registers with the master.
_UNSERVED_S = 2.0


def ask(command: str, key: str, timeout_s: float) -> CommandResult:
    """Send a command and return its answer.

    Raises:
        CommandError: if no node serves commands, or no answer comes in time.
    """
    answered = threading.Event()
    found: list[CommandResult] = []

    def take(message: String) -> None:
        answer = read_answer(message.data)
        if answer.command == command:
            found.append(answer)
            answered.set()

    answers = rospy.Subscriber(topics.ANSWER, String, take)
    commands = rospy.Publisher(topics.COMMAND, UICommand, queue_size=1)
    deadline_s = time.monotonic() + timeout_s  # a person waits: no simulated time
    unserved_s = min(deadline_s, time.monotonic() + _UNSERVED_S)
    while not (commands.get_num_connections() and senders(answers)):
        now_s = time.monotonic()
        is_gone = now_s > unserved_s and not _is_served()
        if rospy.is_shutdown() or now_s > deadline_s or is_gone:
            raise CommandError(
                f"no node serves {rospy.resolve_name(topics.COMMAND)}; start it: "
                "roslaunch remodel_console command_server.launch"
            )
        answered.wait(0.02)
    commands.publish(UICommand(command, key))
    if not answered.wait(timeout_s):
        raise CommandError(f"no answer to '{command}' within {timeout_s:.0f} s")
    return found[0]


def _is_served() -> bool:
    """Return whether the master knows a node that takes commands."""
    _publishers, subscribers, _services = rosgraph.Master(rospy.get_name()).getSystemState()
    return rospy.resolve_name(topics.COMMAND) in dict(subscribers)


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
    values = {each.name: getattr(state, each.name) for each in fields(Instantiation)}
    given = {name: v if isinstance(v, str) else tuple(v) for name, v in values.items()}
    return Instantiation(**given | {"cond_transition": tuple(conditions)})
