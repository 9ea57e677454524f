"""Ctrl-C while an engine is judged: a flag that all waits check.

An exception in the middle of a call, such as a request to the engine's node, would leave its
connection unusable for the calls that stop the behavior.
"""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from collections.abc import Callable, Iterator

# [s] Wall time after which a wait checks the flag.
_CHECK_S = 0.05


class InterruptedByUserError(Exception):
    """The user has pressed Ctrl-C."""


class Interrupt:
    """Whether the user has pressed Ctrl-C.

    Attributes:
        is_set: the user has.
    """

    def __init__(self) -> None:
        """Begin before any Ctrl-C."""
        self.is_set = False
        self._is_held = False

    def check(self) -> None:
        """Raise if the user has pressed Ctrl-C.

        Raises:
            InterruptedByUserError: if so, unless it is held back.
        """
        if self.is_set and not self._is_held:
            raise InterruptedByUserError

    def wait_for(
        self, arrived: threading.Condition, condition: Callable[[], object], limit_s: float
    ) -> bool:
        """Wait for a condition as `arrived` does, whose lock is held; return whether it holds.

        Args:
            arrived: is notified when the condition may have changed.
            condition: what is waited for.
            limit_s: no longer than this [s, wall time].

        Raises:
            InterruptedByUserError: as soon as the user has pressed Ctrl-C.
        """
        end = time.monotonic() + limit_s
        while True:
            self.check()
            left = end - time.monotonic()
            if arrived.wait_for(condition, max(0.0, min(left, _CHECK_S))):
                return True
            if left <= _CHECK_S:
                return False

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Hold Ctrl-C back: the waits within go on, and a later check raises."""
        self._is_held = True
        try:
            yield
        finally:
            self._is_held = False

    @contextlib.contextmanager
    def on_sigint(self) -> Iterator[None]:
        """Set the flag at SIGINT, in place of an exception wherever the main thread is."""
        before = signal.signal(signal.SIGINT, self._on_sigint)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    def _on_sigint(self, *_: object) -> None:
        self.is_set = True
