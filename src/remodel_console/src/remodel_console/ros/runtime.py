"""Commands for the behavior that runs: they go to the engine, which acknowledges them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping

import rospy
from flexbe_msgs.msg import CommandFeedback

from remodel_console.core.commands import Command, Verb
from remodel_console.core.run.order import Hold, Release
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.steering import Steering

_LEVEL = 1  # of autonomy when attaching without one: the FlexBE App's first, Low
_ANSWER_S = 5.0  # in which an engine that runs acknowledges a command
_POLL_S = 0.02
_WORDS = {
    Verb.ATTACH: "attach",
    Verb.LOCK: "lock",
    Verb.UNLOCK: "unlock",
    Verb.SWITCH: "switch",
}
_SWITCHED = "prepared"  # the last phase that the engine publishes of a switch that works
_LAST_PHASES = ([_SWITCHED], ["failed"], ["not_switchable"])


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
        word, given = _WORDS[command.verb], command.given
        if command.verb is Verb.SWITCH:
            return self._switch()
        args = self._acknowledged(word, lambda: self._send(command.verb, given))
        return f"acknowledged: {word} {' '.join(args)}".rstrip()

    def _acknowledged(self, word: str, send: Callable[[], None]) -> list[str]:
        """Send something, and return what the engine acknowledges it with."""
        with self._changed:
            self._wanted, self._args = word, None
        send()
        with self._changed:
            self._changed.wait_for(lambda: self._args is not None, _ANSWER_S)
            args, self._wanted = self._args, ""
        if args is None:
            text = f"no engine has acknowledged '{word}' within {_ANSWER_S:.0f} s; "
            raise CommandError(f"{text}does a behavior run?")
        return args

    def _switch(self) -> str:
        """Go on in the saved version, and return once that runs."""
        version = self._steering.version_to_switch_to()
        (phase,) = self._acknowledged("switch", lambda: self._steering.order(version))
        end_s = time.monotonic() + _ANSWER_S
        while phase == _SWITCHED and time.monotonic() < end_s:
            if self._steering.live.world.run.behavior_id == version.source_checksum:
                return f"'{version.name}' continues in the saved version"
            time.sleep(_POLL_S)
        text = f"the engine does not continue in the saved version: {phase.replace('_', ' ')}; "
        raise CommandError(f"{text}its log says why")

    def _send(self, verb: Verb, given: Mapping[str, str]) -> None:
        """Give the order that a command stands for."""
        steering = self._steering
        if verb is Verb.ATTACH:
            level = int(given.get("level", _LEVEL))
            if not 0 <= level <= 255:
                raise CommandError(f"the autonomy level {level} is not allowed; give 0 to 255")
            steering.attach(level)
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
            is_last = message.command != "switch" or message.args in _LAST_PHASES
            if message.command == self._wanted and is_last:
                self._args = list(message.args)
                self._changed.notify_all()
