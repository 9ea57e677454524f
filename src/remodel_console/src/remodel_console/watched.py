"""What is received and kept only while a page shows it."""

from __future__ import annotations

import threading


class Watched:
    """Counts those who watch; pages begin and end on different threads."""

    def __init__(self) -> None:
        """Begin without viewers."""
        self._lock = threading.Lock()
        self._viewers = 0

    @property
    def is_wanted(self) -> bool:
        """Return whether a page or a recorder watches."""
        return self._viewers > 0

    def add_viewer(self, change: int) -> None:
        """Count those who watch: 1 more, or -1."""
        with self._lock:
            self._viewers += change
