"""What each task of a run counts for, and the sums of the run. Pure.

Every view shows these: the pages of the console, the lists of runs, statistics, the report and the
terminal. A task that an earlier run of the product has done says nothing about this run: it is
neither a first pass nor none, and takes no time here. Wires by hand are no tasks of the run.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Set
from dataclasses import dataclass

from remodel_run.progress import Count, Sums
from remodel_run.record import Statistics
from remodel_run.whole_task import counted
from remodel_supervision.core.runs.events import Event, OperationEnded, RunBegun
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


_INSERTION = "InsertCable"


@dataclass(frozen=True)
class RunStatistics:
    """What a run adds to the statistics.

    Attributes:
        run: its number.
        sums: of its tasks.
        utilisation: share of the time from the first operation to the end of the last in which an
            ability was executed, 0 to 1; 0 without operations.
        insertions: of each "component/terminal": operations that inserted an end there.
        failures: those of them that ended with an error.
        done_s: of each task that it has done: [s] ROS time that it took.
    """

    run: int
    sums: Sums
    utilisation: float
    insertions: Counter[str]
    failures: Counter[str]
    done_s: dict[str, float]


def statistics_of_run(run: int, state: RunState, events: Iterable[Event]) -> RunStatistics:
    """Return what a run adds.

    Args:
        run: its number.
        state: after its events.
        events: of the run, in order.
    """
    insertions: Counter[str] = Counter()
    failures: Counter[str] = Counter()
    spans: list[tuple[float, float]] = []
    for event in events:
        if isinstance(event, OperationEnded):
            operation = event.operation
            spans.append((operation.ended_s - operation.elapsed_s, operation.ended_s))
        if not isinstance(event, OperationEnded) or event.operation.ability != _INSERTION:
            continue
        given = dict(event.operation.parameters)
        terminal = f"{given.get('component_id', '?')}/{given.get('terminal_id', '?')}"
        insertions[terminal] += 1
        failures[terminal] += event.operation.has_failed
    return RunStatistics(
        run,
        sums=sums_of(state),
        utilisation=_busy_share(spans),
        insertions=insertions,
        failures=failures,
        done_s={
            task.name: task.cell_s
            for task in state.tasks.values()
            if count_of(task, state) is Count.DONE
        },
    )


def joined(runs: Iterable[RunStatistics]) -> Statistics:
    """Return the statistics of several runs."""
    insertions: Counter[str] = Counter()
    failures: Counter[str] = Counter()
    times: defaultdict[str, list[float]] = defaultdict(list)
    sums, yields, utilisations = [], [], []
    for each in sorted(runs, key=lambda one: one.run):
        insertions.update(each.insertions)
        failures.update(each.failures)
        for wire, time_s in each.done_s.items():
            times[wire].append(time_s)
        share = each.sums.first_pass_yield
        if share is not None:
            sums.append((each.run, each.sums))
            yields.append((each.run, share))
            utilisations.append((each.run, each.utilisation))
    means = [(wire, sum(found) / len(found)) for wire, found in times.items()]
    return Statistics(
        tuple(sums),
        tuple(yields),
        tuple(utilisations),
        tuple(
            (terminal, insertions[terminal], failures[terminal])
            for terminal in sorted(insertions, key=lambda name: (-failures[name], name))
        ),
        tuple(sorted(means, key=lambda mean: (-mean[1], mean[0]))),
    )


def _busy_share(spans: Iterable[tuple[float, float]]) -> float:
    """Return which share of the time between the first and the last of them spans cover."""
    ordered = sorted(spans)
    if not ordered:
        return 0.0
    busy_s, until_s = 0.0, ordered[0][0]
    for start_s, end_s in ordered:
        busy_s += max(0.0, end_s - max(start_s, until_s))
        until_s = max(until_s, end_s)
    whole_s = until_s - ordered[0][0]
    return busy_s / whole_s if whole_s > 0.0 else 0.0
