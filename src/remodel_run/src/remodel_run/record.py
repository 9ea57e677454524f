"""The record of a run, entry by entry, as a person reads it; and statistics across runs."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from remodel_run.progress import Sums


class Kind(Enum):
    """The kind of an entry; the values are those of remodel_msgs/RunEntry, which explains them."""

    RUN = "run"
    TASK = "task"
    STATE = "state"
    FEEDBACK = "feedback"
    RESULT = "result"
    FAILURE = "failure"
    DECISION = "decision"
    OPERATOR = "operator"
    PICTURE = "picture"


@dataclass(frozen=True)
class Entry:
    """One thing that happened, at a ROS time [s]; `values` are named with their units.

    Attributes:
        position: in the record, from 1 and without gaps.
        time_s: 0 if it is not known.
        state_path: as the engine has it.
        state: the same in terms of the chart, as a person reads it; empty where it is not known.
        because: the reason; of OPERATOR, who it was; of PICTURE, the name of its file.
    """

    position: int
    time_s: float
    kind: Kind
    task: str = ""
    behavior: str = ""
    state_path: str = ""
    ability: str = ""
    fault: str = ""
    error_code: int = 0
    text: str = ""
    because: str = ""
    values: tuple[tuple[str, float], ...] = ()
    has_picture: bool = False
    state: str = ""


def entry_words(entry: Entry) -> str:
    """Return an entry as an operator reads it."""
    if entry.kind is Kind.STATE:
        return entry.state or entry.state_path or "the behavior has ended"
    if entry.kind is Kind.FAILURE:
        return f"{fault_words(entry.fault)}: {entry.text}".removesuffix(": ")
    if entry.kind is Kind.DECISION:
        because = f", because {entry.because}" if entry.because else ""
        return f"The cell {decision_words(entry.text)}{because}."
    if entry.kind is Kind.OPERATOR:
        return f"{entry.because}: {entry.text}" if entry.because else entry.text
    if entry.kind is Kind.RUN and entry.because:
        return f"{entry.text}: {entry.because}"
    who = f"{entry.ability}: " if entry.ability else ""
    return f"{who}{entry.text}" or entry.kind.value


_DECISION_WORDS = {
    "retry": "tries again",
    "retry_with": "tries again with changed parameters",
    "look_again": "looks again from another view",
    "other_method": "uses another method",
    "new_part": "starts again with a new part",
    "other_end": "starts again with a new part, its other end first",
    "replan": "replans the rest; the task comes later",
    "set_aside": "skips the task and continues",
    "ask_operator": "asks you",
    "stop": "stops safely",
}


def decision_words(decision: str) -> str:
    """Return what a decision means; one that is not known stays as it is."""
    return _DECISION_WORDS.get(decision, decision.replace("_", " "))


def fault_words(fault: str) -> str:
    """Return a fault's name as a person writes it."""
    return fault.replace("_", " ").capitalize() or "Unknown fault"


@dataclass(frozen=True)
class Statistics:
    """Across the recorded runs of one order, or of all.

    Attributes:
        sums: (number of the run, its sums) of the runs that have ended a task, the oldest first.
        yields: (run, share of first passes) of the same runs.
        utilisations: (run, share of its time in which an ability was executed) of the same runs.
        terminals: (terminal, insertions, failures), those with most failures first.
        wires: (wire, mean time that it took [s]), the slowest first.
    """

    sums: tuple[tuple[int, Sums], ...] = ()
    yields: tuple[tuple[int, float], ...] = ()
    utilisations: tuple[tuple[int, float], ...] = ()
    terminals: tuple[tuple[str, int, int], ...] = ()
    wires: tuple[tuple[str, float], ...] = ()
