"""Drive an engine to its end: sleep until something is due or a message wakes a state.

If a state asks a proxy for something that has not arrived, the proxy's channel remembers the state.
The arrival wakes that state at once, and no other. States without a driver (executed by hand, as
in flexbe_testing) are not remembered; their caller polls them.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import rospy

from flexbe_core.engine.engine import Engine
from flexbe_core.engine.leaf import Leaf
from flexbe_core.engine.supervision import Command, Event
from flexbe_core.ros import clock

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


# [s] Wall time after which events are published even if no state waits.
_REPORT_EVERY_S = 0.01

# [s] Wall time of states that never wait after which cycles of them are put back to their rates.
_SPIN_LIMIT_S = 0.25

# [s] Arrivals that lead to nothing wake the engine at most every _FRUITLESS_S in the long run, and
# freely as long as they are ahead of that by no more than _FRUITLESS_AHEAD_S (ten of them).
_FRUITLESS_S = 0.002
_FRUITLESS_AHEAD_S = 0.02

# [s] Wall time; a shorter wait, as for the next of a flood of arrivals, does not count as one.
_SHORTEST_WAIT_S = 0.001

# [s] Wall time after which the end of ROS is noticed at the latest.
_LONGEST_WAIT_S = 2.0

Arrival = Command | Leaf | None
Inbox = queue.SimpleQueue[Arrival]


class Driver:
    """One run of an engine, on the calling thread.

    Attributes:
        engine: what it drives.
        busy_since: by time.monotonic, when the engine was let run; None while it waits.
    """

    def __init__(
        self,
        engine: Engine,
        inbox: Inbox,
        command: Callable[[Command], None],
        refresh: Callable[[], None],
        report: Callable[[Sequence[Event]], None],
    ) -> None:
        """Prepare a run.

        Args:
            engine: what to drive.
            inbox: where commands and wake-ups arrive; None only has the clock read again.
            command: puts a command in force.
            refresh: called before the engine runs, so that it sees what was set from outside.
            report: publishes events.
        """
        self.engine = engine
        self.busy_since: float | None = None
        self._inbox = inbox
        self._command = command
        self._refresh = refresh
        self._report = report
        self._remembered: set[Waiting] = set()
        self._slice_end = 0.0
        self._fruitless_until = 0.0
        self._postponed: set[Leaf] = set()
        self._was_woken = False
        self._last_now = 0.0

    def wake(self, leaf: Leaf) -> None:
        """Execute this state as soon as possible."""
        self._inbox.put(leaf)

    def remember(self, waiting: Waiting) -> None:
        """Be forgotten by `waiting` when the run ends."""
        self._remembered.add(waiting)

    def drive(self) -> str:
        """Run the engine to its end and return the outcome.

        Raises:
            rospy.ROSInterruptException: if ROS is shut down.
            BehaviorFailure: if a state could not continue and errors end the run.
            Exception: what a root raised that holds no errors.
        """
        alarm = clock.SimulatedAlarm(self._check_clock) if clock.is_simulated() else None
        try:
            with driven_by(self):
                return self._loop(alarm)
        finally:
            self.engine.stop()
            self._report(self.engine.take_events())
            for waiting in self._remembered:
                waiting.forget(self)
            if alarm is not None:
                alarm.close()

    def _loop(self, alarm: clock.SimulatedAlarm | None) -> str:
        engine = self.engine
        running_since = time.monotonic()
        while not rospy.is_shutdown():
            if engine.supervision.preempt or engine.next_due() <= self._now():
                self._refresh()
                self.busy_since = time.monotonic()
                self._slice_end = self.busy_since + _REPORT_EVERY_S
                outcome = engine.run(clock.now(), self._is_enough)
                self.busy_since = None
                self._report_facts()
                if outcome is not None:
                    return outcome
                if self._inbox.empty() and engine.next_due() <= clock.now():
                    engine.slow = time.monotonic() - running_since > _SPIN_LIMIT_S
                    continue
            waiting_since = time.monotonic()
            self._wait(alarm)
            if time.monotonic() - waiting_since > _SHORTEST_WAIT_S:
                engine.slow = False
                running_since = time.monotonic()
        raise rospy.ROSInterruptException("ROS was shut down while a behavior ran")

    def _check_clock(self) -> None:
        self._inbox.put(None)

    def _now(self) -> float:
        """Return ROS time; when it jumps back, everything is due."""
        now = clock.now()
        if now < self._last_now:
            self.engine.root.wake()
        self._last_now = now
        return now

    def _is_enough(self) -> bool:
        return self._inbox.qsize() > 0 or time.monotonic() > self._slice_end

    def _report_facts(self) -> None:
        events = self.engine.take_events()
        if events:
            self._report(events)
        elif self._was_woken:
            self._fruitless_until = max(self._fruitless_until, time.monotonic()) + _FRUITLESS_S
        self._was_woken = False

    def _wait(self, alarm: clock.SimulatedAlarm | None) -> None:
        """Wait until something is due or arrives, and take in all that has arrived."""
        timeout = self._timeout(alarm)
        try:
            self._take(
                self._inbox.get(timeout=timeout) if timeout > 0 else self._inbox.get_nowait()
            )
            while True:
                self._take(self._inbox.get_nowait())
        except queue.Empty:
            pass
        if self._postponed and time.monotonic() >= self._fruitless_until - _FRUITLESS_AHEAD_S:
            for leaf in self._postponed:
                self.engine.wake(leaf)
            self._postponed.clear()
            self._was_woken = True

    def _timeout(self, alarm: clock.SimulatedAlarm | None) -> float:
        """Return how long [s] of wall time to wait; 0 or less if there is something to do."""
        due = self.engine.next_due()
        if alarm is not None:
            alarm.set(due)
            timeout = _LONGEST_WAIT_S
        else:
            timeout = min(_LONGEST_WAIT_S, due - clock.now())
        if self._postponed:
            free_at = self._fruitless_until - _FRUITLESS_AHEAD_S
            timeout = min(timeout, free_at - time.monotonic())
        return timeout

    def _take(self, arrival: Arrival) -> None:
        if isinstance(arrival, Leaf):
            if self._fruitless_until - time.monotonic() > _FRUITLESS_AHEAD_S:
                self._postponed.add(arrival)
            else:
                self.engine.wake(arrival)
                self._was_woken = True
        elif arrival is not None:
            self._command(arrival)
