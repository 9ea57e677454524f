"""Text on disk."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from remodel_production.errors import InstanceError


def read_text(file: Path) -> str:
    """Return the text of a file.

    Raises:
        InstanceError: if it cannot be read as UTF-8.
    """
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise InstanceError(f"cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InstanceError(f"is no UTF-8 text: {error.reason} at byte {error.start}") from error


def write_text(file: Path, text: str) -> None:
    """Write a text so that the file always holds the whole old one or the whole new one.

    Raises:
        InstanceError: if it cannot be written.
    """
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        beside.write_text(text, encoding="utf-8")
        beside.replace(file)
    except OSError as error:
        with contextlib.suppress(OSError):
            beside.unlink()
        raise InstanceError(f"{file} cannot be written: {error.strerror}") from error
