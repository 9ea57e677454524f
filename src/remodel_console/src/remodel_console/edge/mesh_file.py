"""Meshes of robots as binary STL, which browsers read."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

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
