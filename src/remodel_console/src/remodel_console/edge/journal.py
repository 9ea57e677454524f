"""The file in which every command is recorded."""

from __future__ import annotations

import logging
import threading
from datetime import UTC, datetime
from pathlib import Path

from remodel_console.core.access import Actor
from remodel_console.core.answer import CommandResult
from remodel_console.core.entry import Entry

_LOG = logging.getLogger(__name__)


class Journal:
    """Appends a line for each command; several threads may write."""

    def __init__(self, path: Path) -> None:
        """Use the file at this path, made with its folder if it is not there.

        Raises:
            OSError: if it cannot be written to.
        """
        self.path = path
        self._lock = threading.Lock()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("a").close()

    def write(self, actor: Actor, answer: CommandResult) -> None:
        """Record a command and its answer; on a full disk, say so: the command is done already."""
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        line = Entry(now, actor, answer).line()
        try:
            with self._lock, self.path.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
        except OSError as error:
            words = "%s cannot be written, so this is not recorded: %s: %s"
            _LOG.error(words, self.path, error, line)
