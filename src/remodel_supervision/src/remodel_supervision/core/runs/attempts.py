"""The behaviors of a run, from its events, with what was decided about each."""

from __future__ import annotations

from dataclasses import dataclass, replace

from remodel_supervision.core.run import Execution, Operation
from remodel_supervision.core.runs.events import (
    Decided,
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
    """The behaviors of a run, gathered event by event (`event_table.py` says by which).

    Attributes:
        begun: the behavior that runs; None between behaviors.
        behavior: name of the one that was begun last.
        operations: of that one.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self._ended: list[Attempt] = []
        self.begun: TaskBegun | None = None
        self.behavior = ""
        self.operations: list[Operation] = []

    @property
    def ended(self) -> tuple[Attempt, ...]:
        """Return those that have ended, in order."""
        return tuple(self._ended)

    def begin(self, event: TaskBegun) -> None:
        """Take in the beginning of a behavior."""
        self.begun, self.behavior, self.operations = event, event.behavior, []

    def operate(self, event: OperationEnded) -> None:
        """Take in an operation of the behavior that runs."""
        self.operations.append(event.operation)

    def end(self, event: TaskEnded) -> None:
        """Take in how the behavior ended by itself, and what that says of earlier ones."""
        begun, self.begun = self.begun, None
        if begun is None:
            return
        if not begun.part.is_attempt and event.placed:
            self._note_placed(event.task)
        is_discarded = begun.part is Part.DISCARD and event.outcome == FINISHED
        if is_discarded or event.denied:
            self._note_not_placed(event.task)
        execution = self._execution(begun, event.outcome, event.at_s, placed=event.placed)
        attempt = Attempt(execution, begun.part, begun.chart, event.path, pictures=event.pictures)
        self._ended.append(attempt)

    def interrupt(self, event: Interrupted) -> None:
        """Take in that the behavior that runs, if one does, was cut off after an operation."""
        begun, self.begun = self.begun, None
        if begun is None:
            return
        at_s = max([begun.at_s, *(operation.ended_s for operation in self.operations)])
        execution = self._execution(begun, INTERRUPTED, at_s, placed=False)
        self._ended.append(Attempt(execution, begun.part, begun.chart, because=event.because))

    def settle(self, event: Settled) -> None:
        """Take in what an inspection has seen."""
        if not event.left and not event.unseen:
            self._note_placed(event.task)

    def decide(self, event: Decided) -> None:
        """Take in what was decided about the last behavior."""
        if self._ended and self._ended[-1].execution.wire == event.task:
            self._ended[-1] = replace(self._ended[-1], decision=event)

    def _note_placed(self, task: str) -> None:
        """Note that the last attempt at a task, if it was interrupted, had placed its part."""
        at_task = [
            n
            for n, each in enumerate(self._ended)
            if each.execution.wire == task and each.part.is_attempt
        ]
        if at_task and self._ended[at_task[-1]].because:
            self._set_placed(at_task[-1], placed=True)

    def _note_not_placed(self, task: str) -> None:
        """Note that a task is not placed: what was, though its behavior failed, is so no longer."""
        for n, attempt in enumerate(self._ended):
            if attempt.execution.wire == task and attempt.execution.placed:
                self._set_placed(n, placed=False)

    def _set_placed(self, n: int, *, placed: bool) -> None:
        attempt = self._ended[n]
        self._ended[n] = replace(attempt, execution=replace(attempt.execution, placed=placed))

    def _execution(self, begun: TaskBegun, outcome: str, at_s: float, *, placed: bool) -> Execution:
        return Execution(
            begun.task,
            begun.behavior,
            begun.attempt,
            outcome,
            placed=placed,
            started_s=begun.at_s,
            ended_s=at_s,
            operations=tuple(self.operations),
        )
