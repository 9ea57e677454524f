"""Commands of pages: who may give them, their execution, and their record."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Protocol

from remodel_console.core.access import Actor, Role
from remodel_console.core.answer import DONE, FAILED, REFUSED, CommandResult
from remodel_console.errors import CommandError

_A = {Role.WATCHER: "a watcher", Role.OPERATOR: "an operator", Role.ENGINEER: "an engineer"}
_LOG = logging.getLogger(__name__)


class Journal(Protocol):
    """The record of commands."""

    def write(self, actor: Actor, answer: CommandResult) -> None:
        """Record a command and its answer."""


class Desk:
    """Executes the commands of all pages."""

    def __init__(self, journal: Journal) -> None:
        """Record commands in a journal."""
        self._journal = journal

    def give(
        self,
        actor: Actor,
        command: str,
        deed: Callable[[], str | None],
        needs: Role = Role.OPERATOR,
    ) -> CommandResult:
        """Execute a command, record it, and return the answer.

        Args:
            actor: who gives it.
            command: what it is, for the record.
            deed: does it, and returns the answer in words.
            needs: the role that the command needs.
        """
        if actor.role.may(needs):
            answer = answer_of(command, deed, _LOG.error)
        else:
            words = f"{actor.name} is {_A[actor.role]}; this needs {_A[needs]}"
            answer = CommandResult(REFUSED, command, words)
        self.record(actor, answer)
        return answer

    def record(self, actor: Actor, answer: CommandResult) -> None:
        """Record a command that was carried out elsewhere, such as signing in."""
        self._journal.write(actor, answer)


def answer_of(
    command: str, deed: Callable[[], str | None], log_error: Callable[..., object]
) -> CommandResult:
    """Execute a command and return the answer; a defect is logged with its trace."""
    try:
        return CommandResult(DONE, command, deed() or "")
    except CommandError as error:
        return CommandResult(FAILED, command, str(error))
    except Exception as error:  # noqa: BLE001 - an answer must come, whatever is wrong
        log_error("the command '%s' failed", command, exc_info=True)
        return CommandResult(FAILED, command, f"internal error: {error!r}; the log has the trace")
