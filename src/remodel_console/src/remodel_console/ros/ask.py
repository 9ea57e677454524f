"""Give one command and wait for its answer."""

from __future__ import annotations

import threading
import time

import rospy
from flexbe_msgs.msg import UICommand
from std_msgs.msg import String

from remodel_console.core.answer import CommandResult, read_answer
from remodel_console.errors import CommandError
from remodel_console.ros import topics


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
    while not (commands.get_num_connections() and answers.get_num_connections()):
        if rospy.is_shutdown() or time.monotonic() > deadline_s:
            raise CommandError(
                f"no node serves {rospy.resolve_name(topics.COMMAND)}; start it: "
                "roslaunch remodel_console command_server.launch"
            )
        answered.wait(0.02)
    commands.publish(UICommand(command, key))
    if not answered.wait(timeout_s):
        raise CommandError(f"no answer to '{command}' within {timeout_s:.0f} s")
    return found[0]
