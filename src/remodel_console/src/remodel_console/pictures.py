"""The newest picture of each camera; written by any thread, read by the pages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from remodel_console.watched import Watched


@dataclass(frozen=True)
class Picture:
    """A picture as JPEG; `number` counts those of its camera."""

    number: int
    jpeg: bytes


class Pictures(Watched):
    """Holds the pictures, and knows whether a page shows them."""

    def __init__(self) -> None:
        """Start without pictures and without viewers."""
        super().__init__()
        self._newest: dict[str, Picture] = {}
        self._wake: Callable[[], None] = lambda: None

    def on_change(self, wake: Callable[[], None]) -> None:
        """Have a function called, on any thread, after each new picture."""
        self._wake = wake

    def take(self, camera: str, jpeg: bytes) -> None:
        """Take in a picture."""
        with self._lock:
            before = self._newest.get(camera)
            self._newest[camera] = Picture(before.number + 1 if before else 1, jpeg)
        self._wake()

    def newest(self, camera: str) -> Picture | None:
        """Return the newest picture of a camera; None before the first."""
        return self._newest.get(camera)
