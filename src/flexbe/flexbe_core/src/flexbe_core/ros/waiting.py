"""Which states wait for what: how an arriving message wakes the state that polls for it.

If a state asks a proxy for something that has not arrived, the proxy's channel remembers the state.
The arrival wakes that state at once, and no other. States without a driver (executed by hand, as
in flexbe_testing) are not remembered; their caller polls them.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from flexbe_core.engine.engine import Engine
from flexbe_core.engine.leaf import Leaf


class Driver(Protocol):
    """Runs an engine on the calling thread."""

    engine: Engine

    def wake(self, leaf: Leaf) -> None:
        """Execute this state as soon as possible; may be called from any thread."""

    def remember(self, waiting: Waiting) -> None:
        """Be forgotten by `waiting` when the drive ends."""


_local = threading.local()


@contextmanager
def driven_by(driver: Driver) -> Iterator[None]:
    """Name the driver of what this thread executes."""
    before = getattr(_local, "driver", None)
    _local.driver = driver
    try:
        yield
    finally:
        _local.driver = before


def wake_at(ros_time_s: float) -> None:
    """Have the calling state executed next at this ROS time [s], or earlier if it is woken.

    For states that wait for a time: they are exact, and not polled at their rate. To be called in
    each execution that returns None.
    """
    driver = getattr(_local, "driver", None)
    if driver is not None:
        driver.engine.executing.alarm = ros_time_s


class Waiting:
    """The states that wait for one thing."""

    def __init__(self) -> None:
        """Begin with none."""
        self._states: set[tuple[Driver, Leaf]] = set()

    def add_caller(self) -> None:
        """Remember the state that this thread executes; to be called before checking for arrivals.

        The other order would lose what arrives in between.
        """
        driver = getattr(_local, "driver", None)
        if driver is not None:
            self._states.add((driver, driver.engine.executing))
            driver.remember(self)

    def wake_all(self) -> None:
        """Wake and forget all states; call it after the arrival has been stored."""
        states, self._states = self._states, set()
        for driver, leaf in states:
            driver.wake(leaf)

    def forget(self, driver: Driver) -> None:
        """Forget the states of a driver."""
        for entry in tuple(self._states):
            if entry[0] is driver:
                self._states.discard(entry)
