"""Write several files so that all are there, each whole, or none is changed."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from flexbe_synthesizer.edge.regular_file import read_regular
from flexbe_synthesizer.errors import OutputError


def write_all(files: Mapping[Path, str | bytes]) -> tuple[Path, ...]:
    """Write the contents and return the paths whose content changed; others are left alone.

    Each content goes to a file beside its place first; only when all of them lie on the disk are
    they renamed. If a rename fails, those before it are taken back.

    Raises:
        OutputError: if the files cannot be written; then none is changed.
    """
    before: dict[Path, bytes | None] = {}
    staged: dict[Path, Path] = {}
    try:
        for path, given in files.items():
            content = given.encode() if isinstance(given, str) else given
            before[path] = read_regular(path) if path.exists() else None
            if before[path] != content:
                path.parent.mkdir(parents=True, exist_ok=True)
                staged[path] = _stage(path, content)
        _rename_all(staged, before)
    except OSError as error:
        raise OutputError(f"nothing was written: {error}") from error
    finally:
        for temporary in staged.values():
            temporary.unlink(missing_ok=True)
    return tuple(staged)


def _stage(path: Path, content: bytes) -> Path:
    """Return a file beside the path that holds the content, flushed to the disk."""
    mode = path.stat().st_mode & 0o777 if path.exists() else 0o644
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            os.fchmod(file.fileno(), mode)
            file.flush()
            os.fsync(file.fileno())
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
    return temporary


def _rename_all(staged: Mapping[Path, Path], before: Mapping[Path, bytes | None]) -> None:
    done: list[Path] = []
    try:
        for path, temporary in staged.items():
            temporary.replace(path)
            done.append(path)
    except OSError:
        for path in done:
            content = before[path]
            if content is None:
                path.unlink(missing_ok=True)
            else:
                _stage(path, content).replace(path)
        raise
