"""Statistics across runs: yield, utilisation, terminals that jam, time for each wire. Pure."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from remodel_run.progress import Count, Sums
from remodel_run.record import Statistics
from remodel_supervision.core.runs.events import Event, OperationEnded
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.core.runs.sums import count_of, sums_of

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
