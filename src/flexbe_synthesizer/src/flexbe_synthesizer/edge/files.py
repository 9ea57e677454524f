"""Read and write files safely, recorded runs among them; have Graphviz draw one."""

from __future__ import annotations

import errno
import json
import os
import stat
import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from flexbe_synthesizer.errors import DrawingError, OutputError

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


def read_regular_text(path: Path) -> str:
    """Return the text of a file in UTF-8.

    Raises:
        OSError: if it cannot be read.
        ValueError: if it is not UTF-8.
    """
    return read_regular(path).decode("utf-8-sig").replace("\r\n", "\n")


def _expect_regular(path: Path, mode: int) -> None:
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "no regular file", str(path))


# Write several files so that all are there, each whole, or none is changed


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
    except (OSError, ValueError) as error:  # a text, or a name, with half a character
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


# Whether files and folders are still as they were when they were read


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


def _stamp_of(path: str | Path) -> Stamp | None:
    """Return the stamp of a file or folder; None if it is absent."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return Stamp(status.st_mtime_ns, status.st_size, status.st_ino)


class Stamps:
    """The stamps of all that a result was read from."""

    def __init__(self) -> None:
        self._taken: dict[str, Stamp | None] = {}
        self._is_any_fresh = False

    def take(self, path: str | Path) -> Stamp | None:
        """Return the stamp of a file or folder that is about to be read; None if it is absent."""
        stamp = _stamp_of(path)
        self._is_any_fresh |= stamp is not None and stamp.is_fresh
        return self._taken.setdefault(str(path), stamp)

    def still_hold(self) -> bool:
        """Return whether all that was read is certainly unchanged."""
        is_any_fresh, taken = self._is_any_fresh, self._taken.items()
        return not is_any_fresh and all(_stamp_of(path) == stamp for path, stamp in taken)


FORMATS = (".svg", ".png")
_TIMEOUT_S = 60.0  # a chart of a thousand states takes about ten seconds


def dot_picture(dot: str, suffix: str) -> bytes:
    """Return the picture of a DOT text in the format that a file suffix names.

    Raises:
        DrawingError: if the suffix is no format, or Graphviz fails.
    """
    if suffix not in FORMATS:
        raise DrawingError(f"unknown suffix {suffix!r} of a picture; allowed: .svg, .png")
    command = ["dot", f"-T{suffix[1:]}"]
    if suffix == ".png":
        command.append("-Gdpi=144")
    try:
        done = subprocess.run(
            command, input=dot.encode(), capture_output=True, timeout=_TIMEOUT_S, check=True
        )
    except FileNotFoundError as error:
        raise DrawingError(
            "Graphviz is not installed; install it: apt-get install graphviz"
        ) from error
    except subprocess.CalledProcessError as error:
        reason = error.stderr.decode(errors="replace").strip()
        raise DrawingError(f"Graphviz failed: {reason}") from error
    except subprocess.TimeoutExpired as error:
        raise DrawingError(f"Graphviz took more than {_TIMEOUT_S:.0f} s") from error
    return done.stdout


def render_dot(dot: str, path: Path) -> None:
    """Write the picture of a DOT text to a path, in the format that its suffix says.

    Raises:
        DrawingError: if the suffix is no format, Graphviz fails, or the file can't be written.
    """
    try:
        write_all({path: dot_picture(dot, path.suffix)})
    except (DrawingError, OutputError) as error:
        raise DrawingError(f"{path} could not be drawn: {error}") from error


def read_run(path: Path) -> tuple[tuple[str, str], ...]:
    """Return (path of the state, outcome) of each step of a run.

    Raises:
        DrawingError: if the file is no such record.
    """
    try:
        steps = json.loads(read_regular_text(path))
        if not isinstance(steps, list):
            raise ValueError("it is no list")
        return tuple(map(_step, steps))
    except (OSError, ValueError, RecursionError) as error:
        raise DrawingError(
            f'{path} is no record of a run, [["/Locate", "located"], ...]: {error}'
        ) from error


def _step(step: object) -> tuple[str, str]:
    if isinstance(step, list) and len(step) == 2 and all(isinstance(part, str) for part in step):
        return step[0], step[1]
    raise ValueError(f"found {step!r} in it, not a path and an outcome")
