"""Serve `/flexbe/uicommand`: one command after another, each answered and acknowledged."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

import rospy
from flexbe_msgs.msg import UICommand
from std_msgs.msg import String

from remodel_console.core.access import Actor, Role
from remodel_console.core.answer import DONE, REFUSED, CommandResult
from remodel_console.core.commands import read_command
from remodel_console.core.key import is_allowed
from remodel_console.core.settings import Settings
from remodel_console.desk import Journal, answer_of
from remodel_console.ros import topics
from remodel_console.ros.runtime import Runtime
from remodel_console.session import Session

_MOST_WAITING = 64  # commands; more than an operator types before they are executed


class CommandServer:
    """Executes the commands that arrive, in a thread of its own."""

    def __init__(
        self,
        session: Session,
        runtime: Runtime,
        settings: Callable[[], Settings],
        journal: Journal | None = None,
    ) -> None:
        """Start serving.

        Args:
            session: what is edited.
            runtime: commands to the engine.
            settings: returns whether commands are accepted now, and the key they must contain.
            journal: where commands are recorded.
        """
        self._journal = journal
        self._session = session
        self._runtime = runtime
        self._settings = settings
        self._waiting: queue.Queue[UICommand] = queue.Queue(_MOST_WAITING)
        self._notification = rospy.Publisher(topics.NOTIFICATION, String, queue_size=10)
        self._answers = rospy.Publisher(topics.ANSWER, String, queue_size=10)
        self._worker = threading.Thread(target=self._work, name="commands", daemon=True)
        self._worker.start()
        rospy.Subscriber(topics.COMMAND, UICommand, self._take, queue_size=_MOST_WAITING)

    def _take(self, message: UICommand) -> None:
        try:
            self._waiting.put_nowait(message)
        except queue.Full:
            words = f"{_MOST_WAITING} commands are waiting already; send this one again later"
            self._publish(CommandResult(REFUSED, message.command, words))

    def _work(self) -> None:
        while not rospy.is_shutdown():
            try:
                message = self._waiting.get(timeout=1.0)
            except queue.Empty:
                continue
            answer = self._answer(message)
            if self._journal is not None:
                node = message._connection_header["callerid"]
                self._journal.write(Actor(node, topics.COMMAND, Role.OPERATOR), answer)
            self._publish(answer)

    def _answer(self, message: UICommand) -> CommandResult:
        """Execute one command and return the answer."""
        text, settings = message.command, self._settings()
        if not settings.are_commands_allowed:
            words = "commands of topics are switched off on the console's Configuration page"
            return CommandResult(REFUSED, text, words)
        if not is_allowed(message.key, settings.command_key):
            rospy.logwarn("a command with a wrong key was refused: %s", text)
            return CommandResult(REFUSED, text, "the key is wrong; ask who configured this console")
        return answer_of(text, lambda: self._carry_out(text), rospy.logerr)

    def _carry_out(self, text: str) -> str:
        command = read_command(text)
        does = self._runtime if command.verb in Runtime.VERBS else self._session
        return does.carry_out(command)

    def _publish(self, answer: CommandResult) -> None:
        """Publish an answer, and the acknowledgement that the FlexBE App would give."""
        if answer.state == DONE:
            rospy.loginfo("%s", answer)
            self._notification.publish(answer.command)
        elif answer.state == REFUSED:
            self._notification.publish("")
        else:
            rospy.logwarn("%s", answer)
        self._answers.publish(str(answer))
