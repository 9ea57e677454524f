"""What operators and safety controllers ask of a run, and when they get their answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from remodel_supervision.core.runs.events import Answered, Command, Commanded
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.errors import CellError

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
