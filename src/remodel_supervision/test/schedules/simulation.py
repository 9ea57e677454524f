"""Clock, events, chance and trace of one schedule."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from random import Random
from typing import Any

from greenlet import getcurrent

# [s] that a message takes, and at most while messages are slow.
_USUAL_S = (0.001, 0.006)


class ViolationError(BaseException):
    """What must always hold does not. Not an Exception: no code in between may handle it."""


class Simulation:
    """One thread of time.

    Attributes:
        now_s: [s] since the schedule began.
        random: of everything.
        hub: the greenlet that runs the events.
        slow_until_s: [s] until when messages take longer.
        slow_s: [s] that they take then at most.
        duplicates: [1] share of requests that are sent twice.
        trace: what happened, if it is kept.
    """

    def __init__(self, seed: int, *, tracing: bool = False) -> None:
        self.now_s = 0.0
        self.random = Random(seed)
        self.hub = getcurrent()
        self.slow_until_s, self.slow_s, self.duplicates = 0.0, 0.0, 0.0
        self.tracing = tracing
        self.trace: list[str] = []
        self.violation: ViolationError | None = None
        self._events: list[tuple[float, int, Callable[..., None], tuple[Any, ...]]] = []
        self._count = 0
        self._limit_s = 0.0

    def at(self, at_s: float, call: Callable[..., None], *args: Any) -> None:
        self._count += 1
        due_s = at_s if at_s > self.now_s else self.now_s
        heapq.heappush(self._events, (due_s, self._count, call, args))

    def after(self, delay_s: float, call: Callable[..., None], *args: Any) -> None:
        self.at(self.now_s + delay_s, call, *args)

    def skip_to(self, at_s: float) -> bool:
        """Have it be a time [s], if nothing happens before; return whether it is."""
        if at_s > self._limit_s or (self._events and self._events[0][0] <= at_s):
            return False
        self.now_s = max(at_s, self.now_s)
        return True

    def latency_s(self) -> float:
        """Return how long a message takes [s]."""
        if self.now_s < self.slow_until_s:
            return self.random.uniform(_USUAL_S[0], self.slow_s)
        return self.random.uniform(*_USUAL_S)

    def chance(self, share: float) -> bool:
        """Return whether something happens that happens in a share of cases [1]."""
        return share > 0.0 and self.random.random() < share

    def run(self, limit_s: float, is_over: Callable[[], bool]) -> bool:
        """Run events until it is over; return whether it is by a limit of time [s]."""
        events, self._limit_s = self._events, limit_s
        while not is_over():
            if not events or events[0][0] > limit_s:
                return False
            self.now_s, _, call, args = heapq.heappop(events)
            call(*args)
            if self.violation is not None:
                raise self.violation
        return True

    def note(self, who: str, what: str, *args: object) -> None:
        """Add a line to the trace, if it is kept."""
        if self.tracing:
            self.trace.append(f"{self.now_s:9.3f}  {who:<14}  {what.format(*args)}")

    def violated(self, what: str) -> None:
        """End the schedule: what must always hold does not."""
        self.note("VIOLATION", "{}", what)
        if self.violation is None:
            self.violation = ViolationError(what)
