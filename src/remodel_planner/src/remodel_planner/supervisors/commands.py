"""What operators and safety controllers ask of a run, and when they get their answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from remodel_planner.core.supervision.events import Answered, Command, Commanded
from remodel_planner.core.supervision.state import RunState, Stage
from remodel_planner.errors import CellError

# Answers a request: whether it was granted, and why not.
Reply = Callable[[bool, str], None]


@dataclass(frozen=True)
class _Pending:
    holds: Callable[[], bool]
    reply: Reply


class PendingReplies:
    """Replies that wait for something, such as that nothing moves."""

    def __init__(self) -> None:
        """Begin without any."""
        self._pending: list[_Pending] = []

    def reply_when(self, holds: Callable[[], bool], reply: Reply) -> None:
        """Answer a request with success as soon as a condition holds."""
        self._pending.append(_Pending(holds, reply))
        self.check()

    def check(self) -> None:
        """Answer the requests whose condition holds."""
        due = [pending for pending in self._pending if pending.holds()]
        self._pending = [pending for pending in self._pending if pending not in due]
        for pending in due:
            pending.reply(True, "")

    def end(self, text: str) -> None:
        """Answer all that is left when the run is over, or this process ends."""
        pending, self._pending = self._pending, []
        for each in pending:
            each.reply(each.holds(), text)


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
            raise CellError(f"{event.task} is {stage.value}; only a task set aside can be retried")
    elif stage.is_lasting or stage in (Stage.ELSEWHERE, Stage.ASKING):
        raise CellError(f"{event.task} is {stage.value}; it cannot be skipped")


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
        raise CellError(f"{event.choice.value} is no answer to it; there are {choices}")
