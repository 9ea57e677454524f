"""How far a run is, as the supervisor publishes it and the console shows it.

The values of the enumerations are those of the messages in remodel_msgs, which explain them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from remodel_run.whole_task import counted


class Phase(Enum):
    """What the supervisor does; see remodel_msgs/UseCaseState."""

    IDLE = "idle"
    STARTING = "starting"
    PLANNING = "planning"
    RUNNING = "running"
    SETTLING = "settling"
    PAUSING = "pausing"
    PAUSED = "paused"
    PROTECTIVE_STOP = "protective_stop"
    ASKING = "asking"
    ENDED = "ended"

    @property
    def words(self) -> str:
        """What an operator reads."""
        return _PHASE_WORDS[self]


_PHASE_WORDS = {
    Phase.IDLE: "idle",
    Phase.STARTING: "starting",
    Phase.PLANNING: "planning",
    Phase.RUNNING: "running",
    Phase.SETTLING: "inspecting the interrupted task",
    Phase.PAUSING: "pausing…",
    Phase.PAUSED: "paused",
    Phase.PROTECTIVE_STOP: "protective stop",
    Phase.ASKING: "waiting for you",
    Phase.ENDED: "ended",
}


class TaskPhase(Enum):
    """How far a task is; see remodel_msgs/TaskState."""

    WAITING = "waiting"
    RUNNING = "running"
    DONE = "done"
    SET_ASIDE = "set_aside"


class Answer(Enum):
    """What an operator may answer to a question; see remodel_msgs/OperatorQuestion."""

    RETRY = "retry"
    FIXED = "fixed"
    MARK_DONE = "mark_done"
    SKIP = "skip"
    REPLAN = "replan"
    STOP = "stop"

    @property
    def words(self) -> str:
        """The label of its button."""
        return _ANSWER_WORDS[self][0]

    @property
    def meaning(self) -> str:
        """What it does."""
        return _ANSWER_WORDS[self][1]


_ANSWER_WORDS = {
    Answer.RETRY: ("Try again", "The cell repeats what is left of the task."),
    Answer.FIXED: ("I have fixed it", "The cell checks, then continues with what is left."),
    Answer.MARK_DONE: ("The task is done", "You confirm it: the cell does not check."),
    Answer.SKIP: ("Skip the task", "The task stays undone; the run continues with the others."),
    Answer.REPLAN: ("Do it later", "The cell replans the rest of the order."),
    Answer.STOP: ("Stop the run", "The run ends safely."),
}


@dataclass(frozen=True)
class HandWire:
    """A wire of the order that no robot of the cell places: a person does.

    Attributes:
        marker: number of the wire on its markers; empty if the design gives none.
        a: terminal of end a, such as "Q1/B1".
        length_m: [m]; 0 if it has no route on the board.
        reason: why no robot places it, for a person.
    """

    name: str
    marker: str
    a: str
    b: str
    colour: str
    section_mm2: float
    length_m: float
    reason: str

    @property
    def words(self) -> str:
        """Where it goes, what it is and how long."""
        length = f", {1000 * self.length_m:.0f} mm" if self.length_m else ""
        return f"{self.a} to {self.b}, {self.colour}, {self.section_mm2:g} mm²{length}"


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
    def is_complete(self) -> bool:
        """Whether all tasks are done; wires by hand are none of them."""
        return self.done_in_all == self.tasks

    @property
    def first_pass_yield(self) -> float | None:
        """The share of first passes among the tasks that were tried, 0 to 1; None without any."""
        return self.first_passes / self.tried if self.tried else None

    @property
    def mean_cycle_s(self) -> float | None:
        """The mean time of a task that is done [s]; None before one is."""
        done = self.first_passes + self.recovered
        return self.done_s / done if done else None


def sums_words(sums: Sums) -> str:
    """Return what became of the tasks, for a person; what there is none of is left out."""
    return ", ".join(_parts(sums))


def _parts(sums: Sums) -> Iterator[str]:
    yield f"{sums.done_in_all} of {counted(sums.tasks, 'task')} done"
    if sums.done_before:
        yield f"{sums.done_before} of them before this run"
    if sums.skipped:
        yield f"{sums.skipped} skipped"
    if sums.interrupted:
        yield f"{sums.interrupted} interrupted"
    if sums.by_hand:
        yield f"{counted(sums.by_hand, 'wire')} by hand"
