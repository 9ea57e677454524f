"""A process that can be killed, stalled and restarted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from schedules.simulation import Simulation


class Node:
    """A process without a supervisor in it.

    Attributes:
        name: for the trace.
        is_up: whether it runs, or is stalled.
        life: how often it was started.
        stalled_s: [s] since when it is stalled; None if it is not.
    """

    def __init__(self, simulation: Simulation, name: str) -> None:
        self.simulation = simulation
        self.name = name
        self.is_up = True
        self.life = 1
        self.stalled_s: float | None = None
        self._wakes_s = 0.0
        self._silence_s = (0.0, 0.0)
        self._deaths: list[Callable[[], None]] = []

    @property
    def answers(self) -> bool:
        """Whether it is up, and not stalled."""
        return self.is_up and self.stalled_s is None

    @property
    def heard_s(self) -> float:
        """[s] until when it has reported regularly."""
        return self.simulation.now_s if self.stalled_s is None else self.stalled_s

    def reported_s(self, due_s: float) -> float:
        """Return when [s] it published a report due then, or its last before it was stalled."""
        begun_s, ended_s = self._silence_s
        return begun_s if begun_s < due_s < ended_s else due_s

    def deliver(self, delay_s: float, call: Callable[..., None], *args: Any) -> None:
        """Have it do something after a time [s]; it does not if it dies before."""
        self.simulation.after(delay_s, self._arrive, self.life, call, args)

    def _arrive(self, life: int, call: Callable[..., None], args: tuple[Any, ...]) -> None:
        if not self.is_up or life != self.life:
            return
        if self.stalled_s is not None:
            self.simulation.at(self._wakes_s, self._arrive, life, call, args)
        else:
            call(*args)

    def on_death(self, call: Callable[[], None]) -> None:
        """Have something called when this life ends."""
        self._deaths.append(call)

    def stall(self, for_s: float) -> None:
        """Stand still for a time [s]."""
        if not self.answers:
            return
        self.simulation.note(self.name, "stalls for {:g} s", for_s)
        self.stalled_s = self.simulation.now_s
        self._wakes_s = self.simulation.now_s + for_s
        self.simulation.at(self._wakes_s, self._wake, self.life)

    def _wake(self, life: int) -> None:
        if life == self.life and self.is_up:
            self.simulation.note(self.name, "wakes up")
            if self.stalled_s is not None:
                self._silence_s = (self.stalled_s, self.simulation.now_s)
            self.stalled_s = None

    def kill(self, for_s: float) -> None:
        """Die, and be restarted after a time [s]."""
        if not self.is_up:
            return
        self.simulation.note(self.name, "is killed; restarts in {:.1f} s", for_s)
        self.is_up, self.stalled_s = False, None
        self.died()
        calls, self._deaths = self._deaths, []
        for call in calls:
            call()
        self.simulation.after(for_s, self._restart)

    def _restart(self) -> None:
        self.simulation.note(self.name, "is up again")
        self.is_up = True
        self.life += 1
        self.restarted()

    def died(self) -> None:
        """Forget what died with it."""

    def restarted(self) -> None:
        """Begin again."""
