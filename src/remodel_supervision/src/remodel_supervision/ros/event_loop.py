"""The event loop of a node: one thread that does everything, in the order in which it arrived."""

from __future__ import annotations

import queue
import threading
import time
import traceback
from collections.abc import Callable
from typing import TypeVar

import rospy

from remodel_production.errors import LostError
from remodel_supervision.core.runs.steady_clock import SteadyClock
from remodel_supervision.errors import LeavingError
from remodel_supervision.supervisors.run_control import Reply

T = TypeVar("T")

# [s] wall time after which the loop looks at its condition although nothing has arrived.
_TURN_S = 0.2

_LEAVING = "this node is shutting down; ask again when it has been restarted"


class RepeatedCall:
    """A call that is repeated until it is cancelled."""

    def __init__(self, period_s: float, call: Callable[[], None]) -> None:
        """Begin one period [s] from now."""
        self.due_s = time.monotonic() + period_s
        self.call = call
        self._period_s = period_s
        self.is_cancelled = False

    def cancel(self) -> None:
        """Call it no more."""
        self.is_cancelled = True

    def fire(self) -> None:
        """Call it; what was missed while this process was stopped is not made up for."""
        self.due_s = time.monotonic() + self._period_s
        self.call()


class RosEventLoop:
    """The supervisors' `EventLoop`, fed from ROS callbacks."""

    def __init__(self) -> None:
        """Begin without anything to do."""
        self._arrived: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._timers: list[RepeatedCall] = []
        self._clock = SteadyClock()
        self._leaving = threading.Event()

    @property
    def is_leaving(self) -> bool:
        """Whether this process is to end."""
        return self._leaving.is_set() or rospy.is_shutdown()

    def now_s(self) -> float:
        """Return the ROS time [s], without jumps."""
        return self._clock.read(rospy.get_time(), time.monotonic())

    def wall_s(self) -> float:
        """Return the wall time [s], monotonic."""
        return time.monotonic()

    def run_until(
        self, holds: Callable[[], bool], limit_s: float, *, while_leaving: bool = False
    ) -> bool:
        """Process what arrives until a condition holds; see `EventLoop`."""
        end_s = time.monotonic() + limit_s
        while True:
            if self.is_leaving and not while_leaving:
                raise LeavingError("this node is shutting down")
            self._fire()
            if holds():
                return True
            now_s = time.monotonic()
            if now_s >= end_s:
                return False
            due_s = min((timer.due_s for timer in self._timers), default=end_s)
            self._process(max(0.0, min(end_s, due_s, now_s + _TURN_S) - now_s))

    def every(self, period_s: float, call: Callable[[], None]) -> RepeatedCall:
        """Have something called again and again, each period of wall time [s]."""
        timer = RepeatedCall(period_s, call)
        self._timers.append(timer)
        return timer

    def leave(self) -> None:
        """Have whatever runs end; from any thread."""
        self._leaving.set()
        self.post(lambda: None)

    def post(self, call: Callable[[], object]) -> None:
        """Have something called on the loop's thread; from any thread."""
        self._arrived.put(call)

    def call(self, call: Callable[[], T], default: T) -> T:
        """Have something called on the loop's thread, and return what it returns; from others.

        Args:
            call: to be done.
            default: returned if this process ends before.
        """
        results: queue.SimpleQueue[T] = queue.SimpleQueue()
        self.post(lambda: results.put(call()))
        return self._awaited(results, default)

    def ask(
        self, request: Callable[[Reply], None], meanwhile: Callable[[], None] = lambda: None
    ) -> tuple[bool, str]:
        """Have a request processed on the loop's thread, and return its reply; from others.

        Args:
            request: to be processed; it gets what it replies with.
            meanwhile: done on this thread once the request is in the queue.
        """
        replies: queue.SimpleQueue[tuple[bool, str]] = queue.SimpleQueue()
        self.post(lambda: request(lambda granted, text: replies.put((granted, text))))
        meanwhile()
        return self._awaited(replies, (False, _LEAVING))

    def background(self, call: Callable[[], T]) -> T:
        """Do on another thread what blocks, and process what arrives meanwhile.

        Raises:
            LeavingError: if this process is to end.
        """
        done = threading.Event()
        results: list[T] = []
        errors: list[BaseException] = []

        def work() -> None:
            try:
                results.append(call())
            except BaseException as error:  # noqa: BLE001 - raised on the loop's thread
                errors.append(error)
            done.set()
            self.post(lambda: None)

        threading.Thread(target=work, name="blocking call", daemon=True).start()
        self.run_until(done.is_set, float("inf"))
        if errors and isinstance(errors[0], LostError) and self.is_leaving:
            raise LeavingError("this node is shutting down")
        if errors:
            raise errors[0]
        return results[0]

    def _awaited(self, results: queue.SimpleQueue[T], default: T) -> T:
        while not self.is_leaving:
            try:
                return results.get(timeout=_TURN_S)
            except queue.Empty:
                continue
        try:
            return results.get(timeout=_TURN_S)
        except queue.Empty:
            return default

    def _fire(self) -> None:
        self._timers = [timer for timer in self._timers if not timer.is_cancelled]
        now_s = time.monotonic()
        for timer in self._timers:
            if timer.due_s <= now_s and not timer.is_cancelled:
                timer.fire()

    def _process(self, wait_s: float) -> None:
        try:
            call = self._arrived.get(timeout=wait_s) if wait_s else self._arrived.get_nowait()
        except queue.Empty:
            return
        try:
            call()
        except LeavingError:
            raise
        except Exception:  # noqa: BLE001 - whatever arrived, what waits for it goes on
            rospy.logerr("%s", traceback.format_exc())
