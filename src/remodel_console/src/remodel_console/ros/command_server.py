"""Serve `/flexbe/uicommand` and `flexbe/operator_input`; commands for the running behavior."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Mapping

import actionlib
import rospy
from flexbe_msgs.msg import BehaviorInputAction, BehaviorInputResult, CommandFeedback, UICommand
from std_msgs.msg import String

from flexbe_core.ros.master import SteadyActionServer
from remodel_console.core.commands import (
    DONE,
    REFUSED,
    Actor,
    Command,
    CommandResult,
    Role,
    Verb,
    is_allowed,
    read_command,
)
from remodel_console.core.running import Hold, Release
from remodel_console.core.settings import Settings
from remodel_console.core.world import InputRequest
from remodel_console.errors import CommandError
from remodel_console.live import Journal, Steering, answer_of
from remodel_console.ros import topics
from remodel_console.session import Session

_LEVEL = 1  # of autonomy when attaching without one: the FlexBE App's first, Low
_ANSWER_S = 5.0  # in which an engine that runs acknowledges a command
_POLL_S = 0.02
_SWITCHED = "prepared"  # the last phase that the engine publishes of a switch that works
_LAST_PHASES = ([_SWITCHED], ["failed"], ["not_switchable"])


class Runtime:
    """Sends commands to the engine and waits until it has taken them."""

    VERBS = (Verb.ATTACH, Verb.LOCK, Verb.UNLOCK, Verb.SWITCH)

    def __init__(self, steering: Steering) -> None:
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
        if command.verb is Verb.SWITCH:
            return self._switch()
        word = command.verb.name.lower()
        args = self._acknowledged(word, lambda: self._send(command.verb, command.given))
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


class InputServer:
    """Holds the requests until a person answers or refuses them, or they are cancelled."""

    def __init__(self, report: Callable[[tuple[InputRequest, ...]], None]) -> None:
        """Begin to serve; `report` gets all open requests after each change, on any thread."""
        self._report = report
        self._lock = threading.Lock()
        self._open: dict[int, tuple[InputRequest, actionlib.ServerGoalHandle]] = {}
        self._count = 0
        self._server = SteadyActionServer(
            topics.OPERATOR_INPUT,
            BehaviorInputAction,
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()

    def answer(self, number: int, literal: str) -> None:
        """Send the text of a literal as the value; see `console.Inputs`."""
        result = BehaviorInputResult(BehaviorInputResult.RESULT_OK, literal)
        self._take(number).set_succeeded(result, "answered by an operator")

    def refuse(self, number: int) -> None:
        """Enter no value: the state ends with `aborted`; see `console.Inputs`."""
        result = BehaviorInputResult(BehaviorInputResult.RESULT_ABORTED, "")
        self._take(number).set_succeeded(result, "an operator entered no value")

    def _take(self, number: int) -> actionlib.ServerGoalHandle:
        with self._lock:
            found = self._open.pop(number, None)
            self._publish()
        if found is None:
            raise CommandError("the request is no longer open: it was answered or withdrawn")
        return found[1]

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        handle.set_accepted()
        with self._lock:
            self._count += 1
            request = InputRequest(self._count, handle.get_goal().msg)
            self._open[self._count] = request, handle
            self._publish()

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        with self._lock:
            for number, (_, held) in tuple(self._open.items()):
                if held == handle:
                    del self._open[number]
            self._publish()
        handle.set_canceled(BehaviorInputResult(), "withdrawn")

    def _publish(self) -> None:
        self._report(tuple(request for request, _ in self._open.values()))
