"""Simulated time, published on /clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

import rospy
from rosgraph_msgs.msg import Clock

# How often the clock is published [s of simulated time].
PERIOD_S = 0.02
# A pause of the process, as for a render, is not made up for by more than this at once [s].
MAX_CATCH_UP_S = 0.1


class KeptTime(Protocol):
    """What keeps the time of a cell that is killed."""

    time_s: float

    def keep_time(self, now_s: float) -> None:
        """Keep the time [s]."""


class SimClock:
    """Time that the cell makes.

    As fast as it can while an ability runs, at the pace of the wall between goals.

    Attributes:
        listeners: are called whenever time has passed.
    """

    def __init__(self, memory: KeptTime | None = None) -> None:
        """Start at one second: zero means "no time yet" in ROS.

        `memory` keeps the time; with it a restarted cell continues where it was, since nodes
        take time that goes back for a restart of the simulation.
        """
        self._memory = memory
        self.listeners: list[Callable[[], None]] = []
        kept_s = memory.time_s if memory else 0.0
        self.now_s = kept_s + PERIOD_S if kept_s else 1.0
        self._published_s = 0.0
        self._wall = time.monotonic()
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        self._publish()

    @property
    def now(self) -> rospy.Time:
        """The simulated time."""
        return rospy.Time.from_sec(self.now_s)

    def advance(self, seconds: float) -> None:
        """Let simulated time pass."""
        self._wall = time.monotonic()
        self._move(seconds)

    def idle(self) -> None:
        """Let as much simulated time pass as wall time has passed."""
        wall = time.monotonic()
        self._move(min(wall - self._wall, MAX_CATCH_UP_S))
        self._wall = wall

    def _move(self, seconds: float) -> None:
        self.now_s += seconds
        if self.now_s - self._published_s >= PERIOD_S:
            self._publish()
        for listener in self.listeners:
            listener()

    def _publish(self) -> None:
        self._published_s = self.now_s
        if self._memory is not None:
            self._memory.keep_time(self.now_s)
        self._publisher.publish(Clock(self.now))
