"""Text on disk."""

from __future__ import annotations

from pathlib import Path

from remodel_planner.errors import InstanceError


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
