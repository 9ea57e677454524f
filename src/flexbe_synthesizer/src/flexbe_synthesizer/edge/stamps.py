"""Whether files and folders are still as they were when they were read."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import NamedTuple

_FRESH_NS = 2 * 10**9  # the coarsest clock of a common file system (FAT) counts in 2 s


class Stamp(NamedTuple):
    """What changes whenever a file is written, or the list of a folder's entries changes."""

    changed_ns: int
    size: int
    inode: int

    @property
    def is_fresh(self) -> bool:
        """Return whether the next change could still leave the same stamp."""
        return time.time_ns() - self.changed_ns < _FRESH_NS


def stamp_of(path: str | Path) -> Stamp:
    """Return the stamp of a file or folder.

    Raises:
        OSError: if it is not there.
    """
    status = os.stat(path)
    return Stamp(status.st_mtime_ns, status.st_size, status.st_ino)


class Stamps:
    """The stamps of all that a result was read from."""

    def __init__(self) -> None:
        """Begin with nothing read."""
        self._taken: dict[str, Stamp | None] = {}
        self._is_any_fresh = False

    def take(self, path: str | Path) -> Stamp | None:
        """Return the stamp of a file or folder that is about to be read; None if it is absent."""
        try:
            stamp = stamp_of(path)
        except OSError:
            stamp = None
        self._is_any_fresh |= stamp is not None and stamp.is_fresh
        return self._taken.setdefault(str(path), stamp)

    def still_hold(self) -> bool:
        """Return whether all that was read is certainly unchanged."""
        return not self._is_any_fresh and all(map(_is_same, self._taken.items()))


def _is_same(taken: tuple[str, Stamp | None]) -> bool:
    path, before = taken
    try:
        status = os.stat(path)
    except OSError:
        return before is None
    return before == (status.st_mtime_ns, status.st_size, status.st_ino)
