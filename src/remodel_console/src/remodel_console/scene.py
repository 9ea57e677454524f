"""A cell in three dimensions as pages draw it, and the meshes of its robots.

The live one is written by ROS threads; that of a replayed run belongs to one page.
"""

from __future__ import annotations

import threading

from remodel_console.core.cell.cell_state import CellState
from remodel_console.watched import Watched


class Scene(Watched):
    """Holds the newest state, and knows how many pages and recorders want it."""

    def __init__(self) -> None:
        """Begin with an empty cell, and without viewers."""
        super().__init__()
        self.now = CellState()


class Meshes:
    """Numbers the files of meshes, by which pages request them; no other file is given away."""

    def __init__(self) -> None:
        """Know no file yet."""
        self._lock = threading.Lock()
        self._files: list[str] = []

    def number(self, file: str) -> int:
        """Return the number of a file that a robot's description names."""
        with self._lock:
            if file not in self._files:
                self._files.append(file)
            return self._files.index(file)

    def file(self, number: int) -> str | None:
        """Return the file of a number; None if there is none."""
        return self._files[number] if 0 <= number < len(self._files) else None
