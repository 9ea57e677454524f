"""Read regular files only, and none that is too large: nothing else can be relied on to end."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

_LARGEST = 64 * 2**20  # [bytes]; the code of a chart of 4 MiB takes less than a quarter of it


def read_regular(path: Path, most: int = _LARGEST) -> bytes:
    """Return the content of a file; a FIFO, a device or a directory is refused at once.

    Args:
        path: the file; links are followed.
        most: how large it may be [bytes].

    Raises:
        OSError: if it cannot be read; `strerror` is the reason.
    """
    _expect_regular(path, os.stat(path).st_mode)
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    with os.fdopen(handle, "rb") as file:
        _expect_regular(path, os.fstat(handle).st_mode)  # it may be another one by now
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"larger than {most >> 20} MiB", str(path))
    return content


def read_regular_text(path: Path, most: int = _LARGEST) -> str:
    """Return the text of a file in UTF-8.

    Raises:
        OSError: if it cannot be read.
        ValueError: if it is not UTF-8.
    """
    return read_regular(path, most).decode("utf-8-sig").replace("\r\n", "\n")


def _expect_regular(path: Path, mode: int) -> None:
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "no regular file", str(path))
