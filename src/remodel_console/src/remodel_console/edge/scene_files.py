"""The files of recorded cells, and the meshes of their robots."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import TextIO

from remodel_console.core.cell.cell_state import Recording

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


_KEPT = 100  # runs; the oldest are deleted
_LARGEST = 2 * 1024**3  # bytes of all files
_MINE = ".scene.jsonl"


class SceneFiles:
    """A folder of recordings; the first line of each says of which run it is."""

    def __init__(self, folder: Path) -> None:
        """Keep recordings in a folder, which is made when the first is written."""
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
        while files and (len(files) >= _KEPT or total > _LARGEST):
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
