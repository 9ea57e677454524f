"""Does what operators and safety controllers ask of the run under way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from remodel_supervision.core.runs.events import Answered, Command, Commanded
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.errors import CellError
from remodel_supervision.supervisors.gate_keeper import GateKeeper
from remodel_supervision.supervisors.ports import Abilities, EventLoop
from remodel_supervision.supervisors.run_record import RunRecord

# Answers a request: whether it was granted, and why not.
Reply = Callable[[bool, str], None]


# [s] wall time after which a command is answered although something does not rest, such as an
# ability server that stalls for ever.
REST_LIMIT_S = 30.0


@dataclass(frozen=True)
class _Pending:
    holds: Callable[[], bool]
    reply: Reply
    restless: Callable[[], str]
    asked_s: float


class PendingReplies:
    """Replies that wait for something, such as that nothing moves."""

    def __init__(self, wall_s: Callable[[], float]) -> None:
        """Begin without any; `wall_s` returns the wall time [s], monotonic."""
        self._wall_s = wall_s
        self._pending: list[_Pending] = []

    def reply_when(
        self, holds: Callable[[], bool], reply: Reply, restless: Callable[[], str]
    ) -> None:
        """Answer a request with success as soon as a condition holds.

        Args:
            holds: the condition.
            reply: to the request.
            restless: returns what does not answer or rest, for a person; empty while an operation
                is under way as it should. The request waits REST_LIMIT_S for it.
        """
        self._pending.append(_Pending(holds, reply, restless, self._wall_s()))
        self.check()

    def check(self) -> None:
        """Answer the requests whose condition holds, or whose time has passed."""
        now_s = self._wall_s()
        for pending in list(self._pending):
            if pending.holds():
                self._answer(pending, True, "")
            elif now_s > pending.asked_s + REST_LIMIT_S and (names := pending.restless()):
                limit = f"{REST_LIMIT_S:.0f} s"
                text = f"not at rest {limit} after it was asked for: {names}; nothing else begins"
                self._answer(pending, False, text)

    def end(self, text: str) -> None:
        """Answer all that is left when the run is over, or this process ends."""
        for pending in list(self._pending):
            granted = pending.holds()
            names = "" if granted else pending.restless()
            self._answer(pending, granted, f"{text}; not at rest: {names}" if names else text)

    def _answer(self, pending: _Pending, granted: bool, text: str) -> None:
        self._pending.remove(pending)
        pending.reply(granted, text)


def require_sense(event: Commanded, state: RunState) -> None:
    """Return if a command makes sense now.

    Raises:
        CellError: with the reason.
    """
    if state.ended is not None:
        raise CellError("the run has ended")
    if event.command not in (Command.SKIP, Command.RETRY):
        return
    if event.task not in state.tasks:
        raise CellError(f"there is no task {event.task!r}; there are {', '.join(state.tasks)}")
    stage = state.tasks[event.task].stage
    if event.command is Command.RETRY:
        if stage is not Stage.SET_ASIDE:
            raise CellError(
                f"{event.task} is {_in_words(stage)}; only a skipped task can be retried"
            )
    elif stage.is_lasting or stage in (Stage.ELSEWHERE, Stage.ASKING):
        raise CellError(f"{event.task} is {_in_words(stage)}; it cannot be skipped")


def _in_words(stage: Stage) -> str:
    match stage:
        case Stage.SET_ASIDE:
            return "skipped"
        case Stage.ELSEWHERE:
            return "being done by another cell"
        case Stage.ASKING:
            return "waiting for an operator's answer"
    return stage.value


def require_open(event: Answered, state: RunState) -> None:
    """Return if an answer fits the open question.

    Raises:
        CellError: with the reason.
    """
    asked = state.question
    if asked is None or asked.number != event.number:
        open_now = f"question {asked.number}" if asked else "none"
        raise CellError(f"question {event.number} is not open; open is {open_now}")
    if event.choice not in asked.choices:
        choices = ", ".join(choice.value for choice in asked.choices)
        raise CellError(
            f"question {asked.number} has no choice {event.choice.value}; its choices are {choices}"
        )


class RunControl:
    """Keeps commands and answers, and replies to them."""

    def __init__(
        self,
        record: RunRecord,
        loop: EventLoop,
        gates: GateKeeper,
        abilities: Abilities,
        doing: Callable[[], str],
    ) -> None:
        """Take the run's record, and what commands stop.

        Args:
            record: of the run.
            loop: time.
            gates: that commands close.
            abilities: whose goals are cancelled.
            doing: returns what is being done now, for a person.
        """
        self._record = record
        self._loop = loop
        self._gate = gates.gate
        self._tasks = gates.tasks
        self._abilities = abilities
        self._doing = doing
        self._replies = PendingReplies(loop.wall_s)
        self._behaviors_ended = 0

    def command(self, event: Commanded, task_under_way: str, reply: Reply) -> None:
        """Do what an operator or a safety controller asks for.

        The reply comes when nothing moves any more: after a pause when the operation under way has
        ended, after a stop of any kind when what ran is cancelled and at rest. If something does
        not rest in time, the reply names it, and nothing else begins before it rests.

        Args:
            event: the command.
            task_under_way: name of the task of the step under way; empty between tasks.
            reply: to the command.
        """
        # At first, and after a loss, it is not known which task is under way.
        is_under_way = bool(event.task) and (
            event.task == task_under_way or self._tasks.is_settling
        )
        if not self._keep(event, reply, lambda: require_sense(event, self._record.state)):
            return
        if self._gate.halt and not self._tasks.behavior:
            self._abilities.cancel()
        if self._gate.halt and self._tasks.behavior and event.command is not Command.PAUSE:
            ended = self._behaviors_ended + 1
            self._reply_when(lambda: self._behaviors_ended >= ended, reply)
        elif event.command is Command.PAUSE or self._gate.halt or is_under_way:
            self._reply_when(lambda: self._tasks.is_still, reply)
        else:
            reply(True, "")

    def answer(self, event: Answered, reply: Reply) -> None:
        """Take an operator's answer."""
        if self._keep(event, reply, lambda: require_open(event, self._record.state)):
            reply(True, "")

    def note_behavior_end(self) -> None:
        """Note that a behavior has ended, and nothing of it moves."""
        self._behaviors_ended += 1
        self.check()

    def check(self) -> None:
        """Reply to the commands that have been carried out, or whose time has passed."""
        self._replies.check()

    def end(self) -> None:
        """Reply to all that is left as the run has ended, or this process ends."""
        self._replies.end("the run has ended")

    def _keep(self, event: Commanded | Answered, reply: Reply, require: Callable[[], None]) -> bool:
        """Keep what was asked for if it is possible now; otherwise reply why not."""
        try:
            require()
            self._record.append_now(event)
        except Exception as error:  # noqa: BLE001 - the client gets the reason, whatever it is
            reply(False, str(error))
            return False
        return True

    def _reply_when(self, holds: Callable[[], bool], reply: Reply) -> None:
        asked_s = self._loop.wall_s()

        def restless() -> str:
            names = self._tasks.restless(asked_s)
            return names or (self._doing() if self._gate.halt and not self._tasks.is_still else "")

        self._replies.reply_when(holds, reply, restless)
