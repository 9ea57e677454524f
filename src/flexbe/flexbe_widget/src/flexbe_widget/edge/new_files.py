"""Write files that do not exist yet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from flexbe_widget.errors import RepositoryError


def write_new_files(folder: Path, files: Mapping[str, str]) -> None:
    """Write files below a folder, all or none.

    Raises:
        RepositoryError: if one exists already, or cannot be written.
    """
    there = [path for path in files if (folder / path).exists()]
    if there:
        raise RepositoryError(f"{folder / there[0]} exists already; nothing was written")
    try:
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise RepositoryError(f"cannot write into {folder}: {error}") from error
