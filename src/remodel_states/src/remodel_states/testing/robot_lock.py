"""One goal at a time for a robot whose abilities are served by several processes."""

from __future__ import annotations

import fcntl
import os


class RobotLock:
    """A lock on a file; the system frees it when the process that holds it dies."""

    def __init__(self, path: str) -> None:
        """Name the file; it is made when it is needed."""
        self._path = path
        self._file: int | None = None

    def take(self) -> bool:
        """Return whether the lock was free, and is now held."""
        file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            return False
        self._file = file
        return True

    def free(self) -> None:
        """Release it, if it is held."""
        file, self._file = self._file, None
        if file is not None:
            os.close(file)
