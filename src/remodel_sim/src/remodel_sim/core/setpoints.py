"""Timed postures that a robot driver follows, as ros_control's joint trajectory controller does."""

from __future__ import annotations

from remodel_work.geometry import Array

# Times that differ by less are the same: stamps are rounded [s].
SAME_S = 1e-4


class Setpoints:
    """Postures and when they are due; between two of them the robot moves evenly."""

    def __init__(self) -> None:
        """Begin without any."""
        self._due: list[tuple[float, Array]] = []
        self._reached: tuple[float, Array] | None = None

    def add(self, at_s: float, joints: Array) -> None:
        """Be in a posture, (joints,), at a time [s]; it replaces what was due then and later."""
        self._due = [point for point in self._due if point[0] < at_s - SAME_S]
        self._due.append((at_s, joints))

    def clear(self) -> None:
        """Drop all, and where they led to."""
        self._due, self._reached = [], None

    def step(self, now_s: float, time_step: float, joints: Array) -> Array | None:
        """Return where to be after a step, (joints,); None: nothing is due, stay.

        Args:
            now_s: when it begins [s].
            time_step: [s].
            joints: where the robot was sent last, (joints,).
        """
        if not self._due:
            self._reached = None
            return None
        end_s = now_s + time_step
        began_s, begun = self._reached or (now_s, joints)
        while self._due and self._due[0][0] <= end_s + SAME_S:
            began_s, begun = self._due.pop(0)
        reached = begun
        if self._due and began_s < end_s:
            due_s, there = self._due[0]
            began_s = max(began_s, now_s)
            reached = begun + (end_s - began_s) / (due_s - began_s) * (there - begun)
        self._reached = max(began_s, end_s), reached
        return reached
