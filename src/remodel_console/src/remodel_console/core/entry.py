"""The record of commands: one JSON object a line, for people and programs."""

from __future__ import annotations

import json
from dataclasses import dataclass

from remodel_console.core.access import Actor
from remodel_console.core.answer import CommandResult


@dataclass(frozen=True)
class Entry:
    """One command: when it was given (ISO 8601, UTC), by whom, and its answer."""

    time: str
    actor: Actor
    answer: CommandResult

    def line(self) -> str:
        """Return the line of the record, without its end."""
        return json.dumps(
            {
                "time": self.time,
                "who": self.actor.name,
                "from": self.actor.address,
                "role": self.actor.role.value,
                "command": self.answer.command,
                "state": self.answer.state,
                "answer": self.answer.words,
            },
            ensure_ascii=False,
        )
