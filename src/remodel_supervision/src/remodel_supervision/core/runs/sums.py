"""What each task of a run counts for, and the sums of the run. Pure.

Every view shows these: the pages of the console, the lists of runs, statistics, the report and the
terminal. A task that an earlier run of the product has done says nothing about this run: it is
neither a first pass nor none, and takes no time here. Wires by hand are no tasks of the run.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Set
from dataclasses import dataclass
from enum import Enum

from remodel_production.core.counted import counted
from remodel_supervision.core.runs.events import RunBegun
from remodel_supervision.core.runs.state import RunState, Stage, TaskProgress


class Count(Enum):
    """What a task counts for; the values are those of remodel_msgs/TaskState.

    DONE_BEFORE: done by an earlier run of the product, or by another cell. DONE: by this run.
    SKIPPED: ended, but not done. INTERRUPTED: begun by this run, which has ended before it. OPEN:
    it waits, or is under way.
    """

    DONE_BEFORE = "done_before"
    DONE = "done"
    SKIPPED = "skipped"
    INTERRUPTED = "interrupted"
    OPEN = "open"


@dataclass(frozen=True)
class Sums:
    """The sums of a run, as of remodel_msgs/RunSums; a cable with its cores is one task.

    Attributes:
        tasks: of the run: the sum of the five counts after it.
        by_hand: wires of the order that are left to a person.
        tried: tasks, each core of a cable its own, that this run began and that have ended.
        first_passes: of those: done at once, and no operation of them failed.
        recovered: of those: done though an operation, or an attempt, had failed.
        done_s: [s] ROS time that the done ones took.
        taken_s: [s] ROS time that all behaviors of the run took.
    """

    tasks: int = 0
    done_before: int = 0
    done: int = 0
    skipped: int = 0
    interrupted: int = 0
    open: int = 0
    by_hand: int = 0
    tried: int = 0
    first_passes: int = 0
    recovered: int = 0
    done_s: float = 0.0
    taken_s: float = 0.0

    @property
    def done_in_all(self) -> int:
        """The number of tasks that are done, by whichever run."""
        return self.done_before + self.done

    @property
    def first_pass_yield(self) -> float | None:
        """The share of first passes among the tasks that were tried, 0 to 1; None without any."""
        return self.first_passes / self.tried if self.tried else None


def count_of(task: TaskProgress, state: RunState) -> Count:
    """Return what a task of a run counts for."""
    if task.stage is Stage.DONE:
        return Count.DONE if task.attempts and not task.by_other else Count.DONE_BEFORE
    if task.stage is Stage.SET_ASIDE:
        return Count.SKIPPED
    return Count.INTERRUPTED if state.ended is not None and task.attempts else Count.OPEN


def sums_of(state: RunState) -> Sums:
    """Return the sums of a run."""
    counts = {name: count_of(task, state) for name, task in state.tasks.items()}
    whole = Counter(
        counts[each.wires[0]]
        if not each.is_cable
        else _of_cable({counts[wire] for wire in each.wires}, has_ended=state.ended is not None)
        for each in state.whole_tasks
    )
    done = [task for name, task in state.tasks.items() if counts[name] is Count.DONE]
    skipped = [name for name in state.tasks if counts[name] is Count.SKIPPED]
    passes = sum(task.first_pass for task in done)
    return Sums(
        tasks=whole.total(),
        done_before=whole[Count.DONE_BEFORE],
        done=whole[Count.DONE],
        skipped=whole[Count.SKIPPED],
        interrupted=whole[Count.INTERRUPTED],
        open=whole[Count.OPEN],
        by_hand=len(state.by_hand),
        tried=len(done) + sum(state.tasks[name].attempts > 0 for name in skipped),
        first_passes=passes,
        recovered=len(done) - passes,
        done_s=sum(task.cell_s for task in done),
        taken_s=state.cell_s,
    )


def sums_words(sums: Sums) -> str:
    """Return what became of the tasks, for a person; what there is none of is left out."""
    before = f", {sums.done_before} of them before" if sums.done_before else ""
    return f"{sums.done_in_all} of {counted(sums.tasks, 'task')} done{before}" + "".join(
        f", {text}" for text in _others(sums)
    )


def begun_words(event: RunBegun) -> str:
    """Return how many tasks a run begins with, for a person."""
    done = frozenset(event.done)
    before = sum(done.issuperset(task.wires) for task in event.whole_tasks)
    by_hand = len(event.by_hand)
    return (
        counted(len(event.whole_tasks), "task")
        + (f", {before} of them done before" if before else "")
        + (f", {counted(by_hand, 'wire')} by hand" if by_hand else "")
    )


def _others(sums: Sums) -> Iterator[str]:
    if sums.skipped:
        yield f"{sums.skipped} skipped"
    if sums.interrupted:
        yield f"{sums.interrupted} interrupted"
    if sums.by_hand:
        yield f"{counted(sums.by_hand, 'wire')} by hand"


def _of_cable(found: Set[Count], *, has_ended: bool) -> Count:
    """Return what a cable counts for, by what its cores do."""
    if found == {Count.DONE_BEFORE}:
        return Count.DONE_BEFORE
    if found <= {Count.DONE_BEFORE, Count.DONE}:
        return Count.DONE
    if not found & {Count.INTERRUPTED, Count.OPEN}:
        return Count.SKIPPED
    is_begun = Count.DONE in found or Count.SKIPPED in found
    if Count.INTERRUPTED in found or (has_ended and is_begun):
        return Count.INTERRUPTED
    return Count.OPEN
