"""Kinds of faults, as data: remodel_msgs/config/faults.yaml describes each field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum


class Do(Enum):
    """What may be done about a failure."""

    RETRY = "retry"
    RETRY_WITH = "retry_with"
    LOOK_AGAIN = "look_again"
    OTHER_METHOD = "other_method"
    NEW_PART = "new_part"
    OTHER_END = "other_end"
    REPLAN = "replan"
    SET_ASIDE = "set_aside"
    ASK_OPERATOR = "ask_operator"
    STOP = "stop"

    @property
    def is_lasting(self) -> bool:
        """Whether the task is not begun again by itself after it."""
        return self in (Do.SET_ASIDE, Do.ASK_OPERATOR, Do.STOP)


@dataclass(frozen=True)
class Change:
    """How a parameter changes with each attempt.

    Attributes:
        by: what is added to it, > 0.
        bound: what it never exceeds.
    """

    by: float
    bound: float


@dataclass(frozen=True)
class Response:
    """One thing to do.

    Attributes:
        do: what.
        times: how often before the next response has its turn.
        change: parameter -> change; only with Do.RETRY_WITH.
    """

    do: Do
    times: int = 1
    change: tuple[tuple[str, Change], ...] = ()


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    Attributes:
        name: stable name.
        codes: error codes (remodel_msgs/ErrorCode) that report it.
        after: how often in a row one of its codes must have come in one task.
        symptoms: what can be seen, felt or heard, a sentence.
        responses: tried in this order; the last is lasting.
        is_geometry: whether the same text again, with what was measured, is no chance: what was
            done in between is not done once more.
        stops_unattended: whether nothing may move after it until a person has inspected the cell.
    """

    name: str
    codes: frozenset[int]
    after: int
    symptoms: str
    responses: tuple[Response, ...]
    stops_unattended: bool = False
    is_geometry: bool = False


class FaultTable:
    """All kinds of faults."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        """Take the faults in the order in which they are tried."""
        self._faults: Mapping[str, Fault] = {fault.name: fault for fault in faults}

    def __getitem__(self, name: str) -> Fault:
        """Return the fault of this name."""
        return self._faults[name]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all faults, in order."""
        return tuple(self._faults)

    def of(self, code: int) -> Fault:
        """Return the fault that an error code reports by itself.

        Raises:
            KeyError: if none does.
        """
        fault = self.diagnose([code])
        if fault is None:
            raise KeyError(f"no fault has error code {code}")
        return fault

    def diagnose(self, codes: Sequence[int]) -> Fault | None:
        """Return the fault that a task's error codes report; None if no fault has the last one.

        Of the faults with the last code, the one that needs the longest row of its codes wins.

        Args:
            codes: of the task's failures so far, the latest last.
        """
        found = [
            fault
            for fault in self._faults.values()
            if fault.after <= _row(codes, fault.codes) and codes[-1] in fault.codes
        ]
        return max(found, key=lambda fault: fault.after, default=None)


def _row(codes: Sequence[int], wanted: frozenset[int]) -> int:
    """Return how many of the latest codes, without a gap, are among those wanted."""
    count = 0
    for code in reversed(codes):
        if code not in wanted:
            break
        count += 1
    return count
