"""Services, called with a limit to the wait, and questions to nodes."""

from __future__ import annotations

import threading
import time
from typing import Any

import rosgraph
import rospy
from flexbe_msgs.msg import UICommand
from genpy import Message
from std_msgs.msg import String

from flexbe_core.ros.connections import senders
from remodel_console.core.answer import CommandResult, read_answer, trouble_words
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
