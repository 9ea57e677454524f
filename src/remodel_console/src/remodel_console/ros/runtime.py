"""Commands for the behavior that runs: they go to the engine, which acknowledges them."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import rospy
from flexbe_msgs.msg import CommandFeedback

from remodel_console.core.commands import Command, Verb
from remodel_console.core.order import Hold, Release
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.steering import Steering

_LEVEL = 1  # of autonomy when attaching without one: the FlexBE App's first, Low
_ANSWER_S = 5.0  # in which an engine that runs acknowledges a command
_WORDS = {
    Verb.ATTACH: "attach",
    Verb.LOCK: "lock",
    Verb.UNLOCK: "unlock",
    Verb.SWITCH: "switch",
}
_SWITCHED, _NOT_SWITCHED = "prepared", ("failed", "not_switchable")  # last phases of a switch
_REPORTED = (_SWITCHED, *_NOT_SWITCHED)


class Runtime:
    """Sends commands to the engine and waits until it has taken them."""

    VERBS = tuple(_WORDS)

    def __init__(self, steering: Steering) -> None:
        """Listen to what the engine acknowledges."""
        self._steering = steering
        self._changed = threading.Condition()
        self._wanted = ""  # word of the command that is to be acknowledged
        self._args: list[str] | None = None  # what it was acknowledged with; None before that
        rospy.Subscriber(topics.FEEDBACK, CommandFeedback, self._take_feedback)

    def carry_out(self, command: Command) -> str:
        """Send a command, and return what the engine says.

        Raises:
            CommandError: if it cannot be sent, is not acknowledged, or did not work.
        """
        word = _WORDS[command.verb]
        with self._changed:
            self._wanted, self._args = word, None
        self._send(command.verb, command.given)
        with self._changed:
            self._changed.wait_for(lambda: self._args is not None, _ANSWER_S)
            args, self._wanted = self._args, ""
        if args is None:
            text = f"no engine has acknowledged '{word}' within {_ANSWER_S:.0f} s; "
            raise CommandError(f"{text}does a behavior run?")
        if word == "switch" and args[0] in _NOT_SWITCHED:
            text = f"the engine goes on in its own version: {args[0].replace('_', ' ')}; "
            raise CommandError(f"{text}its log says why")
        return f"acknowledged: {word} {' '.join(args)}".rstrip()

    def _send(self, verb: Verb, given: Mapping[str, str]) -> None:
        """Give the order that a command stands for."""
        steering = self._steering
        if verb is Verb.ATTACH:
            level = int(given.get("level", _LEVEL))
            if not 0 <= level <= 255:
                raise CommandError(f"the autonomy level {level} is not allowed; give 0 to 255")
            steering.attach(level)
        elif verb is Verb.SWITCH:
            steering.switch()
        elif verb is Verb.UNLOCK:
            steering.order(Release())
        else:
            steering.order(Hold(self._level_path(int(given.get("level", 0)))))

    def _level_path(self, level: int) -> str:
        """Return the path of a level of the active state: 0 is the state itself."""
        levels = self._steering.live.world.run.holdable()
        if not -len(levels) <= level < len(levels):
            text = ", ".join(levels) or "none, since no behavior runs"
            raise CommandError(f"there is no level {level} of the active state; levels: {text}")
        return levels[level]

    def _take_feedback(self, message: CommandFeedback) -> None:
        with self._changed:
            is_last = message.command != "switch" or message.args[:1] in ([p] for p in _REPORTED)
            if message.command == self._wanted and is_last:
                self._args = list(message.args)
                self._changed.notify_all()
