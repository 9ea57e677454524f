"""The process of a supervisor: a greenlet, with the supervisors' event loop in it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from greenlet import greenlet

from remodel_supervision.errors import LeavingError
from schedules.simulation import Simulation, ViolationError

T = TypeVar("T")

# Things done at one moment after which a process counts as one that turns in circles.
_TURNS = 5000


class KilledError(BaseException):
    """The process is dead: raised out of whatever it calls."""


class RepeatedCall:
    """A call that is repeated until it is cancelled."""

    def __init__(self, period_s: float, call: Callable[[], None], now_s: float) -> None:
        """Begin one period [s] from now."""
        self.due_s = now_s + period_s
        self.period_s = period_s
        self.call = call

    def cancel(self) -> None:
        self.due_s = float("inf")


@dataclass
class Ambush:
    """What happens to the process at one of its next calls.

    Attributes:
        steps: calls until then.
        stall_s: [s] for which it stalls; None: it is killed.
    """

    steps: int
    stall_s: float | None


class Process:
    """One life of a supervisor's process, and its `EventLoop`.

    Attributes:
        is_dead: whether it was killed, or has ended.
        is_leaving: whether it is to end.
        noticed_leaving: whether it knows.
        ambush: see Ambush; None if nothing happens.
    """

    def __init__(
        self,
        simulation: Simulation,
        name: str,
        main: Callable[[Process], None],
        on_end: Callable[[], None],
    ) -> None:
        self.simulation = simulation
        self.name = name
        self.is_dead = False
        self.is_leaving = False
        self.ambush: Ambush | None = None
        self.noticed_leaving = False
        self._main = main
        self._on_end = on_end
        self._inbox: deque[Callable[[], object]] = deque()
        self._open: dict[int, Callable[[Any], None]] = {}
        self._requests = 0
        self._timers: list[RepeatedCall] = []
        self._turned_s, self._turns = 0.0, 0
        self._stalled_until_s = 0.0
        self._waiting = 0
        self._is_waiting = False
        self._greenlet = greenlet(self._run)
        simulation.after(0.0, self._greenlet.switch)

    # --- EventLoop

    def now_s(self) -> float:
        self.require_alive()
        return self.simulation.now_s

    def wall_s(self) -> float:
        self.require_alive()
        return self.simulation.now_s

    def run_until(
        self, holds: Callable[[], bool], limit_s: float, *, while_leaving: bool = False
    ) -> bool:
        end_s = self.simulation.now_s + limit_s
        while True:
            self.require_alive()
            self._require_progress()
            if self.is_leaving and not while_leaving:
                self.noticed_leaving = True
                raise LeavingError("this node is shutting down")
            self._fire()
            if holds():
                return True
            if self.simulation.now_s >= end_s:
                return False
            if self._inbox:
                self._process(self._inbox.popleft())
            else:
                due_s = min([end_s, *[timer.due_s for timer in self._timers]])
                if not self.simulation.skip_to(due_s):
                    self._sleep(due_s)

    def every(self, period_s: float, call: Callable[[], None]) -> RepeatedCall:
        timer = RepeatedCall(period_s, call, self.simulation.now_s)
        self._timers = [each for each in self._timers if each.due_s < float("inf")] + [timer]
        return timer

    def background(self, begin: Callable[[Callable[[T], None]], None]) -> T:
        """Begin something that calls back when it is done, and process what arrives meanwhile."""
        results: list[T] = []

        def done(result: T) -> None:
            if not results:
                results.append(result)
                self.post(lambda: None)

        begin(done)
        self.run_until(lambda: bool(results), float("inf"))
        return results[0]

    # --- from outside

    def post(self, call: Callable[[], object]) -> None:
        if self.is_dead:
            return
        self._inbox.append(call)
        if self._is_waiting:
            self.simulation.at(self._stalled_until_s, self._wake, self._waiting)

    def request(self, call: Callable[[], T], answer: Callable[[T | None], None]) -> None:
        """Have something called on the loop, and its result returned; None if it never is."""
        if self.is_dead:
            self.simulation.after(self.simulation.latency_s(), answer, None)
            return
        self._requests += 1
        number = self._requests
        self._open[number] = answer

        def do() -> None:
            self.answer(number, call())

        self.post(do)

    def answer(self, number: int, result: object) -> None:
        """Answer a request, unless it was answered before."""
        answer = self._open.pop(number, None)
        if answer is not None and not self.is_dead:
            self.simulation.after(self.simulation.latency_s(), answer, result)

    def ask(
        self,
        request: Callable[[Callable[[bool, str], None]], None],
        answer: Callable[[tuple[bool, str] | None], None],
    ) -> None:
        """Have a request processed on the loop that is replied to later."""
        if self.is_dead:
            self.simulation.after(self.simulation.latency_s(), answer, None)
            return
        self._requests += 1
        number = self._requests
        self._open[number] = answer
        self.post(lambda: request(lambda granted, text: self.answer(number, (granted, text))))

    def leave(self) -> None:
        """Have the process end, as after SIGTERM."""
        if not self.is_dead:
            self.simulation.note(self.name, "is asked to end (SIGTERM)")
            self.is_leaving = True
            self.post(lambda: None)

    def kill(self) -> None:
        if self.is_dead:
            return
        self.simulation.note(self.name, "is killed")
        self._die()
        if self._is_waiting:
            self.simulation.after(0.0, self._greenlet.switch)

    def stall(self, for_s: float) -> None:
        """Stop the process for a time [s]."""
        self.simulation.note(self.name, "stalls for {:g} s", for_s)
        self._stalled_until_s = max(self._stalled_until_s, self.simulation.now_s + for_s)

    # --- from inside

    def require_alive(self) -> None:
        """Raise KilledError if the process is dead."""
        if self.is_dead:
            raise KilledError

    def _require_progress(self) -> None:
        """End the schedule if the process does many things while no time passes."""
        if self.simulation.now_s != self._turned_s:
            self._turned_s, self._turns = self.simulation.now_s, 0
        self._turns += 1
        if self._turns > _TURNS:
            self.simulation.violated(f"{self.name} turns in circles")
            self._die()
            raise KilledError

    def step(self) -> None:
        """Pass a point at which the process may be killed or stalled."""
        self.require_alive()
        self._require_progress()
        ambush = self.ambush
        if ambush is None:
            return
        ambush.steps -= 1
        if ambush.steps > 0:
            return
        self.ambush = None
        if ambush.stall_s is None:
            self.simulation.note(self.name, "is killed in the middle of a step")
            self._die()
            raise KilledError
        self.stall(ambush.stall_s)
        self._sleep(self._stalled_until_s)
        self.require_alive()

    def _die(self) -> None:
        self.is_dead = True
        waiting, self._open = self._open, {}
        for answer in waiting.values():
            self.simulation.after(self.simulation.latency_s(), answer, None)

    def _run(self) -> None:
        try:
            self._main(self)
        except KilledError:
            pass
        except ViolationError as violation:
            self.simulation.violation = violation
        except Exception as error:  # noqa: BLE001 - a bug of the program under test
            import traceback

            text = traceback.format_exc()
            self.simulation.violated(f"{self.name} crashed: {error!r}\n{text}")
        finally:
            if not self.is_dead:
                self._die()
            self.simulation.note(self.name, "has ended")
            self._on_end()

    def _sleep(self, until_s: float) -> None:
        self._waiting += 1
        if until_s < float("inf"):
            self.simulation.at(until_s, self._wake, self._waiting)
        self._is_waiting = True
        self.simulation.hub.switch()
        self._is_waiting = False

    def _wake(self, waiting: int) -> None:
        if waiting != self._waiting or not self._is_waiting:
            return
        if self.simulation.now_s < self._stalled_until_s and not self.is_dead:
            self.simulation.at(self._stalled_until_s, self._wake, waiting)
            return
        self._stalled_until_s = 0.0
        self._greenlet.switch()

    def _fire(self) -> None:
        now_s = self.simulation.now_s
        for timer in self._timers:
            if timer.due_s <= now_s:
                timer.due_s = now_s + timer.period_s
                timer.call()

    def _process(self, call: Callable[[], object]) -> None:
        try:
            call()
        except LeavingError:
            raise
        except Exception as error:  # noqa: BLE001 - as the real loop does, which logs it
            import traceback

            text = traceback.format_exc()
            self.simulation.violated(f"{self.name}: an arrival raised {error!r}\n{text}")
