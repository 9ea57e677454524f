"""What became of the tasks of a run, as the supervisor sums it up, in an operator's words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum


class Count(Enum):
    """What a task counts for; the values are those of remodel_msgs/TaskState."""

    DONE_BEFORE = "done_before"
    DONE = "done"
    SKIPPED = "skipped"
    INTERRUPTED = "interrupted"
    OPEN = "open"


@dataclass(frozen=True)
class Sums:
    """The sums of a run, as remodel_msgs/RunSums explains them; times in ROS time [s]."""

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
        """Return how many tasks are done, by whichever run."""
        return self.done_before + self.done

    @property
    def is_complete(self) -> bool:
        """Return whether all tasks are done; wires by hand are none of them."""
        return self.done_in_all == self.tasks

    @property
    def first_pass_yield(self) -> float | None:
        """Return the share of first passes; None before a task has ended."""
        return self.first_passes / self.tried if self.tried else None

    @property
    def mean_cycle_s(self) -> float | None:
        """Return the mean time of a task that is done [s]; None before one is."""
        done = self.first_passes + self.recovered
        return self.done_s / done if done else None


def sums_words(sums: Sums) -> str:
    """Return what became of the tasks; what there is none of is left out."""
    return ", ".join(_parts(sums))


def _parts(sums: Sums) -> Iterator[str]:
    yield f"{sums.done_in_all} of {sums.tasks} task{'' if sums.tasks == 1 else 's'} done"
    if sums.done_before:
        yield f"{sums.done_before} of them before this run"
    if sums.skipped:
        yield f"{sums.skipped} skipped"
    if sums.interrupted:
        yield f"{sums.interrupted} interrupted"
    if sums.by_hand:
        yield f"{sums.by_hand} wire{'' if sums.by_hand == 1 else 's'} by hand"
