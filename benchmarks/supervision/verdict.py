"""What became of one run of the campaign, from its events."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from remodel_planning.core.use_case.fault import Do
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Decided,
    Ending,
    Event,
    OperationEnded,
    RunEnded,
    Settled,
    TaskEnded,
)
from remodel_supervision.core.runs.state import PERSON_FIRST

# Who has handled a fault first.
INSIDE, TASK, USE_CASE = "action or behavior", "task", "use case"
LEVELS = {"action": INSIDE, "behavior": INSIDE, "task": TASK, "use_case": USE_CASE}
_OF_THE_TASK = (Do.RETRY, Do.RETRY_WITH, Do.LOOK_AGAIN, Do.NEW_PART)

# The abilities that withdraw an end and empty the hand when a behavior gives up; they handle
# nothing.
_GIVES_UP = ("ExtractCable", "PlaceCable")

# remodel_msgs/ErrorCode SERVER_HUNG and TIMEOUT: such a goal took as long as it was waited for.
_WAITED_FOR = (1, 7)


@dataclass(frozen=True)
class Verdict:
    """What became of a run.

    Attributes:
        run: its number; 0 if none was begun.
        struck: whether the fault has shown.
        hung: whether it did not end within its limit.
        complete: whether it says that all is done.
        true: whether what it says of each task is what the cell's truth says.
        hand_empty: whether nothing is left in the hand, unless a person was to answer first.
        first: who handled the failure first; empty if nothing failed.
        cell_s: [s] that its operations take in the cell.
        wall_s: [s] wall time.
        explained: whether `explain` names the cause, and the end.
        replayed: whether `replay` finds no difference.
    """

    run: int
    struck: bool = False
    hung: bool = False
    complete: bool = False
    true: bool = False
    hand_empty: bool = False
    first: str = ""
    cell_s: float = 0.0
    wall_s: float = 0.0
    explained: bool = False
    replayed: bool = False

    @property
    def recovered(self) -> bool:
        """Whether all was done in spite of the fault."""
        return self.complete and self.true

    @property
    def ended_well(self) -> bool:
        """Whether it ended by itself, safely, and can be explained."""
        safe = not self.hung and self.true and self.hand_empty
        return safe and self.explained and self.replayed


def is_complete(events: Sequence[Event]) -> bool:
    """Return whether a run has ended with all tasks done."""
    last = events[-1]
    return isinstance(last, RunEnded) and last.ending is Ending.COMPLETE


def needs_person(events: Sequence[Event]) -> bool:
    """Return whether nothing may move, not even to empty the hand, before a person answers."""
    last = next((e.operation for e in reversed(events) if isinstance(e, OperationEnded)), None)
    return last is not None and last.error_code in PERSON_FIRST


def is_explained(events: Sequence[Event], explanation: str) -> bool:
    """Return whether a run's explanation has each failed operation, and how the run ended."""
    failed = [
        event.operation
        for event in events
        if isinstance(event, OperationEnded) and event.operation.error_code
    ]
    failures = (f"error {operation.error_code}: {operation.text}" for operation in failed)
    return all(line in explanation for line in failures) and "\nended " in explanation


def decided_first(events: Sequence[Event], fault: str) -> str:
    """Return who decided first about a fault of a name; empty if no level did."""
    return next(
        (_level(event) for event in events if isinstance(event, Decided) and event.fault == fault),
        "",
    )


def _level(event: Decided) -> str:
    return TASK if event.do in _OF_THE_TASK else USE_CASE


def handled_first(events: Sequence[Event], codes: Collection[int]) -> str:
    """Return who did something first about the first failure with one of some codes."""
    failed = ""
    for event in events:
        match event:
            case OperationEnded() if not failed and event.operation.error_code in codes:
                failed = event.task
            case OperationEnded() if failed and event.operation.ability not in _GIVES_UP:
                return INSIDE
            case TaskEnded() if failed and event.outcome == "finished":
                return INSIDE
            case Decided() if failed:
                return _level(event)
    return ""


def cell_s(events: Sequence[Event], durations_s: Mapping[str, float], inspection_s: float) -> float:
    """Return how long the operations of a run take in the cell [s].

    Args:
        events: of the run.
        durations_s: [s] ability -> what it takes there.
        inspection_s: [s] of an inspection.
    """
    total_s = 0.0
    for event in events:
        if isinstance(event, OperationEnded):
            total_s += _took_s(event.operation, durations_s)
        elif isinstance(event, Settled):
            total_s += inspection_s
    return total_s


def _took_s(operation: Operation, durations_s: Mapping[str, float]) -> float:
    usual_s = durations_s.get(operation.ability, 0.0)
    waited = operation.error_code in _WAITED_FOR
    return max(usual_s, operation.elapsed_s) if waited else usual_s
