"""What each task of a run counts for, and the sums of the run. Pure.

Every view shows these: the pages of the console, the lists of runs, statistics, the report and the
terminal. A task that an earlier run of the product has done says nothing about this run: it is
neither a first pass nor none, and takes no time here. Wires by hand are no tasks of the run.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Set

from remodel_run.progress import Count, Sums
from remodel_run.whole_task import counted
from remodel_supervision.core.runs.events import RunBegun
from remodel_supervision.core.runs.state import RunState, Stage, TaskProgress


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
