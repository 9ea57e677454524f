"""Time in one process: the cell makes it, and everything else waits in it.

Nothing reads a wall clock, and nothing has a thread of its own: what happens follows from the order
and the seed alone. While an ability runs, time passes by the ticks of the physics; while nothing
runs, it is set to when something is due next.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import rospy


class StuckError(Exception):
    """Everything waits, and nothing will ever happen."""


class CellClock:
    """The cell's time, which is ROS's in this process.

    Attributes:
        now_s: [s] since the beginning, which is second 1: zero means "no time yet" in ROS.
    """

    def __init__(self) -> None:
        """Begin, and have rospy use this time: without a node it has none of its own."""
        self.now_s = 1.0
        rospy.rostime.set_rostime_initialized(True)
        self._tell()

    @property
    def now(self) -> rospy.Time:
        """The time as messages have it."""
        return rospy.Time.from_sec(self.now_s)

    def advance(self, seconds: float) -> None:
        """Let time pass [s]."""
        self.now_s += seconds
        self._tell()

    def idle(self) -> None:
        """Nothing passes by itself."""

    def close(self) -> None:
        """Have rospy be without a time again, as before."""
        rospy.rostime._rostime_current = None
        rospy.rostime.set_rostime_initialized(False)

    def _tell(self) -> None:
        rospy.rostime._rostime_current = self.now


class Part(Protocol):
    """What takes its turn in the loop."""

    def turn(self) -> bool:
        """Do what is due; return whether there was anything."""

    def next_due_s(self) -> float:
        """Return when [s] something is due although nothing else happens; infinity if never."""


class _Timer:
    """A call that is repeated."""

    def __init__(self, due_s: float, period_s: float, call: Callable[[], None]) -> None:
        self.due_s, self.period_s, self.call = due_s, period_s, call

    def cancel(self) -> None:
        """Call it no more."""
        self.due_s = math.inf


class CellLoop:
    """The event loop of a supervisor, by the cell's time; see supervisors.ports.EventLoop.

    Attributes:
        parts: those that take turns, in this order.
    """

    def __init__(self, clock: CellClock) -> None:
        """Begin without parts."""
        self.parts: list[Part] = []
        self._clock = clock
        self._timers: list[_Timer] = []

    def now_s(self) -> float:
        """Return the cell's time [s]."""
        return self._clock.now_s

    def wall_s(self) -> float:
        """Return the cell's time [s]: it is the only one."""
        return self._clock.now_s

    def run_until(
        self, holds: Callable[[], bool], limit_s: float, *, while_leaving: bool = False
    ) -> bool:
        """Let the parts take turns until a condition holds, or a limit of time [s] has passed.

        Raises:
            StuckError: if there is no limit, and nothing will ever happen.
        """
        end_s = self._clock.now_s + limit_s
        while True:
            self._fire()
            if holds():
                return True
            if self._clock.now_s >= end_s:
                return False
            if not any(part.turn() for part in self.parts):
                self._pass_to(min(end_s, self._next_due_s()))

    def every(self, period_s: float, call: Callable[[], None]) -> _Timer:
        """Have something called again and again, each period [s]."""
        timer = _Timer(self._clock.now_s + period_s, period_s, call)
        self._timers.append(timer)
        return timer

    def _fire(self) -> None:
        now_s = self._clock.now_s
        self._timers = [timer for timer in self._timers if timer.due_s < math.inf]
        for timer in tuple(self._timers):
            if timer.due_s <= now_s:
                timer.due_s = now_s + timer.period_s
                timer.call()

    def _next_due_s(self) -> float:
        timers = (timer.due_s for timer in self._timers)
        parts = (part.next_due_s() for part in self.parts)
        return min((*timers, *parts), default=math.inf)

    def _pass_to(self, at_s: float) -> None:
        if at_s == math.inf:
            raise StuckError("everything waits, and nothing is due")
        if at_s > self._clock.now_s:
            self._clock.advance(at_s - self._clock.now_s)
