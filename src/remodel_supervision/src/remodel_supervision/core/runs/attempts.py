"""The behaviors of a run, from its events, with what was decided about each."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from remodel_supervision.core.run import Execution, Operation
from remodel_supervision.core.runs.events import (
    Decided,
    Event,
    Interrupted,
    OperationEnded,
    Part,
    Settled,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.state import FINISHED

INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Attempt:
    """One behavior of a task, ended or interrupted.

    Attributes:
        part: of the task that it did.
        chart: of the behavior, XML.
        path: of the states that were entered, as the engine published them.
        pictures: names of files in the run's folder.
        because: of the interruption; empty if it ended.
        decision: what was done about its failure; None if nothing was.
    """

    execution: Execution
    part: Part
    chart: str
    path: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()
    because: str = ""
    decision: Decided | None = None


class Attempts:
    """The behaviors of a run that have ended, gathered event by event."""

    def __init__(self) -> None:
        """Begin without any."""
        self._ended: list[Attempt] = []
        self._begun: TaskBegun | None = None
        self._operations: list[Operation] = []

    @property
    def ended(self) -> tuple[Attempt, ...]:
        """Return those that have ended, in order."""
        return tuple(self._ended)

    def add(self, event: Event) -> None:
        """Take in the next event of the run."""
        ended, begun = self._ended, self._begun
        match event:
            case TaskBegun():
                self._begun, self._operations = event, []
            case OperationEnded():
                self._operations.append(event.operation)
            case TaskEnded() if begun is not None:
                if not begun.part.is_attempt and event.placed:
                    _note_placed(ended, event.task)
                is_discarded = begun.part is Part.DISCARD and event.outcome == FINISHED
                if is_discarded or event.denied:
                    _note_not_placed(ended, event.task)
                execution = _execution(
                    begun, event.outcome, event.placed, event.at_s, operations=self._operations
                )
                ended.append(
                    Attempt(execution, begun.part, begun.chart, event.path, pictures=event.pictures)
                )
                self._begun = None
            case Interrupted() if begun is not None:
                at_s = max([begun.at_s, *(operation.ended_s for operation in self._operations)])
                execution = _execution(begun, INTERRUPTED, False, at_s, operations=self._operations)
                ended.append(Attempt(execution, begun.part, begun.chart, because=event.because))
                self._begun = None
            case Settled() if not event.left and not event.unseen:
                _note_placed(ended, event.task)
            case Decided() if ended and ended[-1].execution.wire == event.task:
                ended[-1] = replace(ended[-1], decision=event)


def attempts_of(events: Iterable[Event]) -> tuple[Attempt, ...]:
    """Return the behaviors of a run that have ended, in order."""
    attempts = Attempts()
    for event in events:
        attempts.add(event)
    return attempts.ended


def _note_placed(ended: list[Attempt], task: str) -> None:
    """Note that the last attempt at a task, if it was interrupted, had placed its part."""
    at_task = [n for n, a in enumerate(ended) if a.execution.wire == task and a.part.is_attempt]
    if at_task and ended[at_task[-1]].because:
        attempt = ended[at_task[-1]]
        ended[at_task[-1]] = replace(attempt, execution=replace(attempt.execution, placed=True))


def _note_not_placed(ended: list[Attempt], task: str) -> None:
    """Note that a task is not placed: what was, though its behavior failed, is so no longer."""
    for n, attempt in enumerate(ended):
        if attempt.execution.wire == task and attempt.execution.placed:
            ended[n] = replace(attempt, execution=replace(attempt.execution, placed=False))


def _execution(
    begun: TaskBegun, outcome: str, placed: bool, at_s: float, operations: list[Operation]
) -> Execution:
    return Execution(
        begun.task,
        begun.behavior,
        begun.attempt,
        outcome,
        placed=placed,
        started_s=begun.at_s,
        ended_s=at_s,
        operations=tuple(operations),
    )
