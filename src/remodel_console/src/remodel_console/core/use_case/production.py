"""Production figures of a run: first-pass yield, cycle times, and what was recovered from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from remodel_console.core.use_case.use_case import UseCase
from remodel_run.progress import Count, Sums
from remodel_run.record import fault_words


@dataclass(frozen=True)
class Figures:
    """What the charts show: of the tasks that this run has done or skipped, in the run's order.

    Attributes:
        sums: of the run.
        tasks: names of the tasks that this run tried.
        yields: share of first passes among the tasks up to each one, 0 to 1.
        done: names of those that it has done.
        cycles_s: time that each of these took [s].
        recoveries: (cause, failures that were recovered from) by number, the largest first.
    """

    sums: Sums = field(default_factory=Sums)
    tasks: tuple[str, ...] = ()
    yields: tuple[float, ...] = ()
    done: tuple[str, ...] = ()
    cycles_s: tuple[float, ...] = ()
    recoveries: tuple[tuple[str, int], ...] = ()


def figures(use_case: UseCase) -> Figures:
    """Return the figures of a run.

    A failure counts as recovered from once its task is done, with a person's help or without.
    """
    tried = [task for task in use_case.tasks if task.is_tried]
    passes = 0
    yields = []
    for number, task in enumerate(tried, start=1):
        passes += task.first_pass
        yields.append(passes / number)
    done = {task.name: task.taken_s for task in tried if task.counts_as is Count.DONE}
    recovered = Counter(
        fault_words(failure.fault) for failure in use_case.failures if failure.task in done
    )
    return Figures(
        use_case.sums,
        tasks=tuple(task.name for task in tried),
        yields=tuple(yields),
        done=tuple(done),
        cycles_s=tuple(done.values()),
        recoveries=tuple(sorted(recovered.items(), key=lambda item: (-item[1], item[0]))),
    )
