"""The one thread that owns the cell.

It runs the abilities, and answers requests between their ticks. rospy's threads only leave requests
here: belief and plant are used by this thread alone. The abilities of two robots take turns: each
does one step, then a tick passes for both. In a simulated cell time runs as fast as the machine
allows while an ability runs; between goals the scene is frozen and time goes on at the wall's pace,
so that results depend on the seed and the goals alone, not on how long a client thinks.
"""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import rospy

from remodel_skills.cell import Cell
from remodel_skills.ros.job import Job
from remodel_work.errors import AbilityError, CellError

T = TypeVar("T")

# The idle loop checks for shutdown and publishes the time this often [s of wall time].
IDLE_S = 0.01


class Clock(Protocol):
    """The time of a cell."""

    @property
    def now_s(self) -> float:
        """The time [s]."""

    @property
    def now(self) -> rospy.Time:
        """The time as messages have it."""

    def idle(self) -> None:
        """Do what time takes to go on while nothing runs; returns at once."""


class Owner:
    """Runs the cell. `spin` must be called by the thread that built the cell."""

    def __init__(self, cell: Cell, clock: Clock) -> None:
        """Take a cell over."""
        self.cell = cell
        self.clock = clock
        self.jobs: list[Job] = []
        # Not a SimpleQueue: its get() waits forever once a signal has come during a timeout.
        self._requests: queue.Queue[Callable[[], None]] = queue.Queue()
        self._frozen_until_s = -math.inf

    def job_of(self, robot: str) -> Job | None:
        """Return what a robot is doing."""
        return next((job for job in self.jobs if robot in job.robots), None)

    def post(self, action: Callable[[], None]) -> None:
        """Queue an action for the time between two ticks; from any thread, returns at once."""
        self._requests.put(action)

    def ask(self, question: Callable[[], T], timeout_s: float) -> T:
        """Evaluate a function between two ticks; from any thread but the owner's.

        Raises:
            CellError: when there is no answer in time, or what the question itself raises.
        """
        answer: _Answer[T] = _Answer(question)
        self.post(answer.find)
        return answer.wait(timeout_s)

    def freeze(self, seconds: float) -> None:
        """Do nothing for so long: no step, no answer, no cancel; only the clock goes on."""
        self._frozen_until_s = self.clock.now_s + seconds

    def spin(self, is_over: Callable[[], bool]) -> None:
        """Run until `is_over` returns that the node ends."""
        pause = threading.Event()
        while not is_over():
            if self.clock.now_s < self._frozen_until_s:
                pause.wait(IDLE_S)
                self.clock.idle()
                continue
            if not self.turn(0.0 if self.jobs else IDLE_S):
                self.clock.idle()
        self.stop()

    def turn(self, wait_s: float = 0.0) -> bool:
        """Answer what was asked, and let one tick pass if a goal is being done.

        Args:
            wait_s: [s] wall time for which to wait for a request.

        Returns:
            whether a goal is, or was, being done.
        """
        self._serve(wait_s)
        if not self.jobs:
            return False
        self._tick()
        return True

    def stop(self) -> None:
        """Leave all goals where they are."""
        for job in self.jobs:
            job.stop()
        self.jobs.clear()

    def _serve(self, wait_s: float) -> None:
        try:
            action = self._requests.get(block=wait_s > 0.0, timeout=wait_s or None)
            while True:
                action()
                action = self._requests.get_nowait()
        except queue.Empty:
            return

    def _tick(self) -> None:
        for job in tuple(self.jobs):
            if job.step():
                self.jobs.remove(job)
        try:
            if self.jobs:
                self.cell.plant.tick()
            else:
                self.cell.come_to_rest()
        except AbilityError as error:
            # The plant is at fault, whatever the skills were doing.
            rospy.logerr("%s", error)
            for job in self.jobs:
                job.fail(error)
            self.jobs.clear()


class _Answer(Generic[T]):
    """A question on its way to the owner and back."""

    def __init__(self, question: Callable[[], T]) -> None:
        self._question = question
        self._done = threading.Event()
        self._value: T | None = None
        self._error: Exception | None = None

    def find(self) -> None:
        try:
            self._value = self._question()
        except Exception as error:  # noqa: BLE001 - raised again in the thread that asked
            self._error = error
        self._done.set()

    def wait(self, timeout_s: float) -> T:
        if not self._done.wait(timeout_s):
            raise CellError(f"the cell did not answer within {timeout_s:.0f} s; check its log")
        if self._error is not None:
            raise self._error
        return self._value  # type: ignore[return-value]
