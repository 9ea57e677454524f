"""A copy of the tasks and failures of a run, kept up to date by published changes. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from remodel_console.core.use_case.use_case import Failure, Task
from remodel_run.progress import HandWire, TaskPhase

_ENDED = (TaskPhase.DONE, TaskPhase.SET_ASIDE)
_KEPT_EARLY = 1000  # changes; far more than arrive while all tasks are fetched


@dataclass(frozen=True)
class Snapshot:
    """All tasks of a run, in the order of the plan, after so many changes of a series."""

    series: int
    number: int
    tasks: tuple[Task, ...]
    failures: tuple[Failure, ...]
    by_hand: tuple[HandWire, ...] = ()


@dataclass(frozen=True)
class Changes:
    """The tasks that changed and the failures that are new; `replanned`: the order has changed."""

    series: int
    number: int
    tasks: tuple[Task, ...]
    failures: tuple[Failure, ...]
    replanned: bool


@dataclass(frozen=True)
class TaskCopy:
    """What is known of a run's tasks.

    Attributes:
        series: of changes that it follows; 0: none.
        number: of the last changes that it contains.
        tasks: by name, in the order of the plan.
        early: changes that came before those that precede them, or before a snapshot.
        is_reordered: the order of the tasks is not known any more.
    """

    series: int = 0
    number: int = 0
    tasks: Mapping[str, Task] = field(default_factory=dict)
    failures: tuple[Failure, ...] = ()
    by_hand: tuple[HandWire, ...] = ()
    early: tuple[Changes, ...] = ()
    is_reordered: bool = False

    @cached_property
    def in_order(self) -> tuple[Task, ...]:
        """Return the tasks: those that have ended, then the others, each in the plan's order."""
        tasks = self.tasks.values()
        ended = [task for task in tasks if task.phase in _ENDED]
        return (*ended, *(task for task in tasks if task.phase not in _ENDED))

    def needs_snapshot(self, series: int) -> bool:
        """Return whether a snapshot is needed to know the run whose changes have this series."""
        is_gap = any(changes.series == series for changes in self.early)
        return bool(series) and (series != self.series or self.is_reordered or is_gap)

    def with_changes(self, changes: Changes) -> TaskCopy:
        """Return the copy with changes, or with those kept until what precedes them is known."""
        if changes.series == self.series and changes.number <= self.number:
            return self
        if (changes.series, changes.number) != (self.series, self.number + 1):
            return replace(self, early=(*self.early, changes)[-_KEPT_EARLY:])
        return self._applied(changes)._with_early()

    def with_snapshot(self, snapshot: Snapshot) -> TaskCopy:
        """Return the copy as a snapshot has it, unless it is newer already."""
        if snapshot.series == self.series and snapshot.number < self.number:
            return self
        tasks = {task.name: task for task in snapshot.tasks}
        return TaskCopy(
            snapshot.series,
            snapshot.number,
            tasks,
            snapshot.failures,
            by_hand=snapshot.by_hand,
            early=self.early,
        )._with_early()

    def _applied(self, changes: Changes) -> TaskCopy:
        return replace(
            self,
            number=changes.number,
            tasks={**self.tasks, **{task.name: task for task in changes.tasks}},
            failures=(*self.failures, *changes.failures),
            is_reordered=self.is_reordered or changes.replanned,
        )

    def _with_early(self) -> TaskCopy:
        """Return the copy with the early changes that follow it now, and without those it has."""
        copy = replace(self, early=())
        for changes in sorted(self.early, key=lambda each: each.number):
            if changes.series == self.series:
                copy = copy.with_changes(changes)
        return copy
