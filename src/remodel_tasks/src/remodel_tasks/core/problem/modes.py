"""The modes of a wire: which arm starts, with which end, and whether it hands over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from remodel_tasks.core.problem.problem import End, PlannedArm, PlannedWire, Problem, Stage


@dataclass(frozen=True)
class Mode:
    """How a wire is placed.

    Attributes:
        arm: index of the arm that picks the wire, or that holds it at the start.
        first: the end inserted first.
    """

    arm: int
    first: End
    hands_over: bool

    @property
    def number(self) -> int:
        """The kernel's name for the mode."""
        return self.arm * 4 + self.first * 2 + self.hands_over

    @classmethod
    def numbered(cls, number: int) -> Mode:
        """Return the mode of a number."""
        return cls(number >> 2, End(number >> 1 & 1), bool(number & 1))


def possible_modes(problem: Problem) -> dict[str, tuple[Mode, ...]]:
    """Return the modes that reach, stage and own pins leave to each unfinished wire, by name."""
    barred: dict[str, set[End]] = {}
    for pin in problem.pins:
        if pin.before == pin.after:
            barred.setdefault(pin.after, set()).add(pin.after_end)
    return {
        wire.name: tuple(_modes(problem, wire, barred.get(wire.name, set())))
        for wire in problem.wires
        if wire.stage is not Stage.FIXED
    }


def _modes(problem: Problem, wire: PlannedWire, barred: set[End]) -> Iterator[Mode]:
    ends = [wire.first] if wire.first is not None else [end for end in End if end not in barred]
    for index, arm in enumerate(problem.arms):
        if not _starts(arm, wire):
            continue
        for first in ends:
            at_first, at_second = (
                problem.end_terminal(wire, end).position_mm for end in (first, first.other)
            )
            if wire.stage <= Stage.FIRST_IN and not arm.reaches(at_first):
                continue
            if wire.stage is not Stage.HALF and arm.reaches(at_second):
                yield Mode(index, first, False)
            if wire.handover and wire.stage <= Stage.HALF:
                meeting = wire.handover.position_mm
                receives = any(
                    other.reaches(meeting) and other.reaches(at_second)
                    for other in problem.arms
                    if other is not arm
                )
                if receives and arm.reaches(meeting):
                    yield Mode(index, first, True)


def _starts(arm: PlannedArm, wire: PlannedWire) -> bool:
    """Return whether an arm can pick the wire, or holds it already."""
    if wire.stage is Stage.STORED:
        return arm.reaches(wire.slot_mm)
    return arm.holding == wire.name
