"""The last lines of the engine's log, kept for a console that restarts."""

from __future__ import annotations

import json
import logging
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path

from remodel_console.core.run.log_line import LogLine

_KEPT = 500  # lines; as many as a page shows
_LONGEST = 20 * _KEPT  # lines of the file, before it is written again with those kept
_LOG = logging.getLogger(__name__)


class LogFile:
    """Appends each line to a file; several threads may write.

    Where the disk is full, the lines are kept in memory alone, and it says so once.
    """

    def __init__(self, path: Path) -> None:
        """Read the lines that are there, and keep the last ones.

        Raises:
            OSError: if it cannot be read or written.
        """
        self._path = path
        self._lock = threading.Lock()
        self._is_written = True
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("a").close()
        self._lines = deque(_lines(path, _KEPT), maxlen=_KEPT)
        self._count = len(self._lines)
        self._try(self._write_again)

    @property
    def lines(self) -> tuple[LogLine, ...]:
        """Return the last lines."""
        return tuple(self._lines)

    def all_lines(self) -> tuple[LogLine, ...]:
        """Return all lines that the file has; where it cannot be written, the last ones."""
        with self._lock:
            return tuple(_lines(self._path, _LONGEST) if self._is_written else self._lines)

    def write(self, line: LogLine) -> None:
        """Keep a line."""
        with self._lock:
            self._lines.append(line)
            self._try(self._append, line)

    def _try(self, write: Callable[..., None], *args: LogLine) -> None:
        try:
            write(*args)
        except OSError as error:
            if self._is_written:
                _LOG.error("%s cannot be written; lines are lost: %s", self._path, error)
            self._is_written = False
        else:
            self._is_written = True

    def _append(self, line: LogLine) -> None:
        if self._count >= _LONGEST:
            self._write_again()
            return
        with self._path.open("a", encoding="utf-8") as file:
            file.write(_text(line))
        self._count += 1

    def _write_again(self) -> None:
        draft = self._path.with_suffix(".new")
        draft.write_text("".join(map(_text, self._lines)), encoding="utf-8")
        draft.replace(self._path)
        self._count = len(self._lines)


def _text(line: LogLine) -> str:
    return json.dumps([line.time_s, line.code, line.text]) + "\n"


def _lines(path: Path, most: int) -> list[LogLine]:
    """Return the last lines of a file; one that a killed console has cut off is left out."""
    if not path.exists():
        return []
    found = []
    for text in path.read_text(encoding="utf-8").splitlines()[-most:]:
        try:
            found.append(LogLine(*json.loads(text)))
        except (ValueError, TypeError):
            continue
    return found
