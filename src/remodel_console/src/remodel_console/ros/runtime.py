"""Commands for the behavior that runs: they go to the engine, which acknowledges them."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import rospy
from flexbe_msgs.msg import BEStatus, CommandFeedback
from std_msgs.msg import String, UInt8

from remodel_console.core.commands import Command, Verb
from remodel_console.errors import CommandError
from remodel_console.ros import topics

_LEVEL = 1  # of autonomy when attaching without one: the FlexBE App's first, Low
_ANSWER_S = 5.0  # in which an engine that runs acknowledges a command


class Runtime:
    """Sends commands to the engine and waits until it has taken them."""

    VERBS = (Verb.ATTACH, Verb.LOCK, Verb.UNLOCK)

    def __init__(self) -> None:
        """Connect to the engine's topics."""
        self._changed = threading.Condition()
        self._active = ""
        self._feedback: CommandFeedback | None = None
        self._attach = rospy.Publisher(topics.ATTACH, UInt8, queue_size=10)
        self._lock = rospy.Publisher(topics.LOCK, String, queue_size=10)
        self._unlock = rospy.Publisher(topics.UNLOCK, String, queue_size=10)
        rospy.Subscriber(topics.UPDATE, String, self._take_update)
        rospy.Subscriber(topics.STATUS, BEStatus, self._take_status)
        rospy.Subscriber(topics.FEEDBACK, CommandFeedback, self._take_feedback)

    def carry_out(self, command: Command) -> str:
        """Send a command, and return what the engine says.

        Raises:
            CommandError: if it cannot be sent, or is not acknowledged.
        """
        with self._changed:
            self._feedback = None
            word = self._send(command.verb, command.given)
            is_taken = self._changed.wait_for(
                lambda: self._feedback is not None and self._feedback.command == word, _ANSWER_S
            )
            if not is_taken or self._feedback is None:
                text = f"no engine has acknowledged '{word}' within {_ANSWER_S:.0f} s; "
                raise CommandError(f"{text}does a behavior run?")
            return f"acknowledged: {word} {' '.join(self._feedback.args)}".rstrip()

    def _send(self, verb: Verb, given: Mapping[str, str]) -> str:
        """Publish a command and return the word that the engine acknowledges it with."""
        if verb is Verb.ATTACH:
            level = int(given.get("level", _LEVEL))
            if not 0 <= level <= 255:
                raise CommandError(f"the autonomy level {level} is not allowed; give 0 to 255")
            self._attach.publish(level)
            return "attach"
        if verb is Verb.UNLOCK:
            self._unlock.publish("")
            return "unlock"
        self._lock.publish(self._level_path(int(given.get("level", 0))))
        return "lock"

    def _level_path(self, level: int) -> str:
        """Return the path of a level of the active state: 0 is the state itself."""
        parts = self._active.split("/")
        levels = ["/".join(parts[:end]) for end in range(len(parts), 1, -1)]
        if not -len(levels) <= level < len(levels):
            text = ", ".join(levels) or "none, since no behavior runs"
            raise CommandError(f"there is no level {level} of the active state; levels: {text}")
        return levels[level]

    def _take_update(self, message: String) -> None:
        with self._changed:
            self._active = message.data

    def _take_status(self, message: BEStatus) -> None:
        if message.code != BEStatus.STARTED:  # at the end, an empty update comes only sometimes
            with self._changed:
                self._active = ""

    def _take_feedback(self, message: CommandFeedback) -> None:
        with self._changed:
            self._feedback = message
            self._changed.notify_all()
