"""Production figures of a run: first-pass yield, cycle times, and what was recovered from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from remodel_console.core.use_case.use_case import TaskPhase, UseCase, fault_words


@dataclass(frozen=True)
class Figures:
    """What the charts show; tasks count once they are done or skipped, in the run's order.

    Attributes:
        tasks: names of the tasks that count.
        yields: share of first passes among the tasks up to each one, 0 to 1.
        cycles_s: time that each of them took [s].
        recoveries: (cause, failures that were recovered from) by number, the largest first.
    """

    tasks: tuple[str, ...] = ()
    yields: tuple[float, ...] = ()
    cycles_s: tuple[float, ...] = ()
    recoveries: tuple[tuple[str, int], ...] = ()

    @property
    def first_pass_yield(self) -> float | None:
        """Return the share of first passes; None before a task has ended."""
        return self.yields[-1] if self.yields else None

    @property
    def mean_cycle_s(self) -> float | None:
        """Return the mean time of a task [s]; None before one has ended."""
        return sum(self.cycles_s) / len(self.cycles_s) if self.cycles_s else None


@dataclass(frozen=True)
class Statistics:
    """Across the recorded runs of one order, or of all.

    Attributes:
        yields: (number of the run, share of first passes), the oldest first.
        utilisations: (number of the run, share of its time in which an ability was executed).
        terminals: (terminal, insertions, failures), those with most failures first.
        wires: (wire, mean time that it took [s]), the slowest first.
    """

    yields: tuple[tuple[int, float], ...] = ()
    utilisations: tuple[tuple[int, float], ...] = ()
    terminals: tuple[tuple[str, int, int], ...] = ()
    wires: tuple[tuple[str, float], ...] = ()


def figures(use_case: UseCase) -> Figures:
    """Return the figures of a run.

    A failure counts as recovered from once its task is done, with a person's help or without.
    """
    ended = [t for t in use_case.tasks if t.phase in (TaskPhase.DONE, TaskPhase.SET_ASIDE)]
    passes = 0
    yields = []
    for number, task in enumerate(ended, start=1):
        passes += task.first_pass
        yields.append(passes / number)
    done = {task.name for task in ended if task.phase is TaskPhase.DONE}
    recovered = Counter(
        fault_words(failure.fault) for failure in use_case.failures if failure.task in done
    )
    return Figures(
        tasks=tuple(task.name for task in ended),
        yields=tuple(yields),
        cycles_s=tuple(task.taken_s for task in ended),
        recoveries=tuple(sorted(recovered.items(), key=lambda item: (-item[1], item[0]))),
    )
