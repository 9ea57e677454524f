"""The files that the console keeps: settings, commands, log, recorded cells and pictures."""

from __future__ import annotations

import json
import logging
import os
import struct
import threading
from collections import deque
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import TextIO

import cv2
import msgspec
import numpy as np

from flexbe_synthesizer.edge.package_path import find_packages
from remodel_console.core.cell import Recording
from remodel_console.core.commands import Actor, CommandResult
from remodel_console.core.running import LogLine
from remodel_console.core.settings import Settings, read_settings, write_settings
from remodel_console.errors import CommandError, PictureError
from remodel_run.progress import HandWire


def write_private(path: Path, text: str) -> None:
    """Write a file, whole or not at all; its folder is made if it is not there.

    Raises:
        OSError: if it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".new")
    draft.unlink(missing_ok=True)
    with open(draft, "x", encoding="utf-8", opener=private) as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(path)


def private(path: str, flags: int) -> int:
    """Open a file, as `open` wants it of an opener; one that is made is its owner's alone."""
    return os.open(path, flags, 0o600)


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
        entry = {
            "time": datetime.now(UTC).isoformat(timespec="milliseconds"),
            "who": actor.name,
            "from": actor.address,
            "role": actor.role.value,
            "command": answer.command,
            "state": answer.state,
            "answer": answer.words,
        }
        line = json.dumps(entry, ensure_ascii=False)
        try:
            with self._lock, self.path.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
        except OSError as error:
            words = "%s cannot be written, so this is not recorded: %s: %s"
            _LOG.error(words, self.path, error, line)


class SettingsFile:
    """Holds the settings, and keeps them in a file that only its owner can read.

    Attributes:
        now: what is configured.
        on_change: called after each change.
    """

    def __init__(self, path: Path, ros_package_path: str) -> None:
        """Read the file, if it is there.

        Raises:
            ValueError: if it is no settings file.
            OSError: if it cannot be read.
        """
        self._path = path
        self._lock = threading.Lock()
        self._ros_package_path = ros_package_path
        self.on_change: Callable[[], None] = lambda: None
        try:
            self.now = (
                read_settings(path.read_text(encoding="utf-8")) if path.exists() else Settings()
            )
        except ValueError as error:
            raise ValueError(
                f"{path}: {error}; correct it, or delete it to start with the defaults"
            ) from error

    def change(self, changed: Callable[[Settings], Settings]) -> None:
        """Keep what a function makes of the settings; several threads may change them.

        Raises:
            CommandError: if a chart folder cannot be one, or the file cannot be written.
        """
        with self._lock:
            settings = changed(self.now)
            self._keep(settings)
            self.now = settings
        self.on_change()

    def _keep(self, settings: Settings) -> None:
        for folder in settings.chart_folders:
            self._expect_folder(Path(folder))
        try:
            write_private(self._path, write_settings(settings))
        except OSError as error:
            raise CommandError(f"the settings cannot be saved: {error}") from error

    def _expect_folder(self, folder: Path) -> None:
        """Refuse what is no folder, or lies where a page may not add folders."""
        if not folder.is_dir():
            raise CommandError(f"there is no folder {folder}; create it first")
        allowed = tuple(self._grounds())
        if not any(folder.resolve().is_relative_to(ground) for ground in allowed):
            text = f"{folder} lies neither in the home folder nor in a ROS package; "
            raise CommandError(f"{text}name it when the console starts: --user-charts {folder}")

    def _grounds(self) -> Iterator[Path]:
        yield Path.home().resolve()
        packages, _warnings = find_packages(self._ros_package_path)
        yield from (package.folder.resolve() for package in packages)


_PRODUCTS_KEPT = 1000  # products, the latest


class _Product(msgspec.Struct, frozen=True):
    wires: tuple[HandWire, ...]
    ticked: frozenset[str] = frozenset()

    @property
    def is_left(self) -> bool:
        return any(wire.name not in self.ticked for wire in self.wires)


class HandWires:
    """Holds the wires by hand, the same for all pages.

    Attributes:
        on_change: called after each change.
    """

    def __init__(self, path: Path) -> None:
        """Read the file, if it is there.

        Raises:
            ValueError: if it is no file of wires by hand.
            OSError: if it cannot be read.
        """
        self._path = path
        self._lock = threading.Lock()
        self.on_change: Callable[[], None] = lambda: None
        text = path.read_bytes() if path.exists() else b"{}"
        try:
            self._products = msgspec.json.decode(text, type=dict[str, _Product])
        except msgspec.DecodeError as error:
            raise ValueError(
                f"{path}: {error}; correct it, or delete it: then no wire by hand is ticked off"
            ) from error

    def ticked(self, product: str) -> frozenset[str]:
        """Return the names of the wires of a product, by its serial number, that are ticked off."""
        found = self._products.get(product)
        return found.ticked if found is not None else frozenset()

    def left(self) -> tuple[str, tuple[HandWire, ...]]:
        """Return the latest product of which a wire is still to be placed, and all its wires.

        Returns:
            Its serial number, empty if there is no such product.
        """
        left = ((name, each.wires) for name, each in self._products.items() if each.is_left)
        return max(enumerate(left), default=(0, ("", ())))[1]

    def keep(self, product: str, wires: tuple[HandWire, ...]) -> None:
        """Keep the wires by hand of a product; what is ticked off stays so."""
        with self._lock:
            known = self._products.get(product)
            if known is not None and known.wires == wires:
                return
            products = self._with(product, _Product(wires, self.ticked(product)))
            self._products = products  # shown, and not tried again, where it cannot be written
            try:
                self._write(product, products)
            except CommandError as error:
                logging.getLogger(__name__).warning("%s", error)

    def tick(self, product: str, wire: str, *, is_placed: bool) -> None:
        """Tick a wire off, or take its tick back.

        Raises:
            CommandError: if the file cannot be written.
        """
        with self._lock:
            known = self._products.get(product, _Product(()))
            ticked = known.ticked | {wire} if is_placed else known.ticked - {wire}
            products = self._with(product, _Product(known.wires, ticked))
            self._write(product, products)
            self._products = products
        self.on_change()

    def _with(self, product: str, changed: _Product) -> dict[str, _Product]:
        """Return all products with one changed, as the latest."""
        others = {key: each for key, each in self._products.items() if key != product}
        return dict([*others.items(), (product, changed)][-_PRODUCTS_KEPT:])

    def _write(self, product: str, products: dict[str, _Product]) -> None:
        try:
            write_private(self._path, msgspec.json.encode(products).decode() + "\n")
        except OSError as error:
            raise CommandError(f"the wires by hand of {product} cannot be kept: {error}") from error


_LINES_KEPT = 500  # lines; as many as a page shows
_LONGEST_FILE = 20 * _LINES_KEPT  # lines of the file, before it is written again with those kept


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
        self._lines = deque(_lines(path, _LINES_KEPT), maxlen=_LINES_KEPT)
        self._count = len(self._lines)
        self._try(self._write_again)

    @property
    def lines(self) -> tuple[LogLine, ...]:
        """Return the last lines."""
        return tuple(self._lines)

    def all_lines(self) -> tuple[LogLine, ...]:
        """Return all lines that the file has; where it cannot be written, the last ones."""
        with self._lock:
            return tuple(_lines(self._path, _LONGEST_FILE) if self._is_written else self._lines)

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
        if self._count >= _LONGEST_FILE:
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


_HEAD = b"REMODEL".ljust(80)
Vertex = tuple[float, float, float]


@lru_cache(maxsize=64)
def stl_of(file: str) -> bytes:
    """Return a mesh of an .stl or .obj file as STL; of a .obj file, faces are cut to triangles.

    Raises:
        ValueError: if it is of another kind, or broken.
        OSError: if it cannot be read.
    """
    path = Path(file.removeprefix("file://"))
    kind = path.suffix.lower()
    if kind == ".stl":
        return path.read_bytes()
    if kind != ".obj":
        raise ValueError(f"{path} is a mesh of the kind '{kind}'; known are .stl and .obj")
    try:
        triangles = list(_triangles(path.read_text(encoding="utf-8", errors="replace")))
    except (ValueError, IndexError) as error:
        raise ValueError(f"{path} is broken: {error}") from error
    parts = (struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0) for a, b, c in triangles)
    return _HEAD + struct.pack("<I", len(triangles)) + b"".join(parts)


def _triangles(text: str) -> Iterator[tuple[Vertex, Vertex, Vertex]]:
    """Yield the triangles of a .obj file; normals and textures are left out."""
    vertices: list[Vertex] = []
    for line in text.splitlines():
        word, *values = line.split() or [""]
        if word == "v":
            x, y, z = map(float, values[:3])
            vertices.append((x, y, z))
        elif word == "f":
            numbers = [int(value.split("/")[0]) for value in values]
            corners = [vertices[n - 1 if n > 0 else n] for n in numbers]
            for second, third in pairwise(corners[1:]):
                yield corners[0], second, third


RUNS_KEPT = 100  # runs; the oldest are deleted
_LARGEST = 2 * 1024**3  # bytes of all files
_MINE = ".scene.jsonl"


class SceneFiles:
    """A folder of recordings; the first line of each says of which run it is."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def begin(
        self, run: int, order: str, begun_s: float, started_s: float, *, goes_on: bool
    ) -> TextIO:
        """Return the open file of a run's recording.

        Args:
            run: its number in the production database.
            order: its name.
            begun_s: wall time [s].
            started_s: ROS time at which the run started [s]; one with the same goes on, since the
                console was restarted.
            goes_on: the run was interrupted; its recording goes on if there is one.

        Raises:
            OSError: if it cannot be written.
        """
        self._folder.mkdir(parents=True, exist_ok=True)
        known = self._find(run, order, begun_s)
        if known is not None and (goes_on or _head(known).get("started_s") == started_s):
            return known.open("a", encoding="utf-8")
        self._make_room()
        path = self._folder / f"{begun_s:.0f}-{run}{_MINE}"
        file = path.open("w", encoding="utf-8")
        os.chmod(path, 0o600)
        head = {"run": run, "order": order, "begun_s": begun_s, "started_s": started_s}
        file.write(json.dumps(head) + "\n")
        return file

    def read(self, run: int, order: str, begun_s: float) -> Recording | None:
        """Return the recording of a run that began at a wall time [s]; None if there is none."""
        path = self._find(run, order, begun_s)
        if path is None:
            return None
        with path.open(encoding="utf-8", errors="replace") as file:
            next(file, "")
            return Recording.read(file)

    def _find(self, run: int, order: str, begun_s: float) -> Path | None:
        """Return the file of a run: of those of its number and order, the nearest in time."""
        heads = ((path, _head(path)) for path in self._files())
        own = [
            (abs(float(head.get("begun_s", 0.0)) - begun_s), path)
            for path, head in heads
            if (head.get("run"), head.get("order")) == (run, order)
        ]
        return min(own)[1] if own else None

    def _files(self) -> Iterator[Path]:
        if self._folder.is_dir():
            yield from sorted(self._folder.glob(f"*{_MINE}"))

    def _make_room(self) -> None:
        """Delete the oldest recordings if there are too many."""
        files = sorted(self._files(), key=lambda path: path.stat().st_mtime)
        total = sum(path.stat().st_size for path in files)
        while files and (len(files) >= RUNS_KEPT or total > _LARGEST):
            oldest = files.pop(0)
            total -= oldest.stat().st_size
            oldest.unlink()


def _head(path: Path) -> dict[str, object]:
    try:
        with path.open(encoding="utf-8") as file:
            found = json.loads(file.readline())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


_LONGER_SIDE = 960  # [pixels] of the longer side; a page shows no more
_QUALITY = 80
_CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1}


def as_jpeg(data: bytes, height: int, width: int, step: int, encoding: str) -> bytes:
    """Return a picture as JPEG, no larger than pages show it.

    Args:
        data: rows of pixels, each `step` bytes.
        height: rows.
        width: pixels in a row.
        step: bytes in a row.
        encoding: rgb8, bgr8 or mono8, as in sensor_msgs/Image.

    Raises:
        PictureError: if it is no such picture.
    """
    channels = _CHANNELS.get(encoding)
    if channels is None:
        raise PictureError(f"pictures are {', '.join(_CHANNELS)}; this one is {encoding!r}")
    if step < width * channels or len(data) != height * step or not height * width:
        raise PictureError(f"{len(data)} bytes are no picture of {width} x {height} {encoding}")
    rows = np.frombuffer(data, np.uint8).reshape(height, step)[:, : width * channels]
    pixels = rows.reshape(height, width, channels)
    if encoding == "rgb8":
        pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    scale = _LONGER_SIDE / max(height, width)
    if scale < 1:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    _, encoded = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return bytes(encoded)
