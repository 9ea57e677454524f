"""The one gate through which everything passes that makes a cell move.

A state or supervisor asks before it begins an operation; a pause holds it, everything else that
closes the gate (stop, skip, protective stop, shutdown, a lost lease) halts it, and what runs is
cancelled besides. From the permission to the end of the operation the gate counts it as moving. A
command that closes the gate is answered when nothing moves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    AsLeft,
    Blocked,
    Interrupted,
    StopReported,
    TaskElsewhere,
)
from remodel_supervision.core.runs.state import PERSON_FIRST, RunState, Stage

# The feeder asks under this name. No command can stop it: it moves until it has answered.
FEEDER = "feeder"


class Permit(Enum):
    """The answer to a request to begin.

    HELD: not now, ask again. REFUSED: not at all.
    """

    GRANTED = "granted"
    HELD = "held"
    REFUSED = "refused"


@dataclass
class Gate:
    """What closes the gate, and what has passed it.

    Attributes:
        halt: why what runs is to be stopped; empty: it is not.
        hold: why nothing new may begin; empty: it may.
        moving: what has begun and not ended, by the name under which it asked.
    """

    halt: str = ""
    hold: str = ""
    moving: dict[str, str] = field(default_factory=dict)

    @property
    def why(self) -> str:
        """Why the gate is closed; empty if it is open."""
        return self.halt or self.hold

    @property
    def is_still(self) -> bool:
        """Whether nothing moves that has passed the gate."""
        return not self.moving

    def ask(self, name: str, what: str) -> Permit:
        """Return whether an operation may begin; once it is granted it counts as moving.

        Args:
            name: under which its end will be reported, such as the path of a state.
            what: for a person.
        """
        if self.halt:
            return Permit.REFUSED
        if self.hold:
            return Permit.HELD
        self.moving[name] = what
        return Permit.GRANTED

    def end(self, name: str) -> None:
        """Note that an operation has ended; one that never passed changes nothing."""
        self.moving.pop(name, None)

    def clear(self) -> None:
        """Note that no ability moves any more; a feeder that is at work is not one."""
        for name in self.moving.keys() - {FEEDER}:
            self.end(name)


@dataclass(frozen=True)
class Circumstances:
    """What closes the gate besides the state of the run.

    Attributes:
        disowned: why this supervisor does not own the cell any more; empty if it does.
        lost_lease: why this cell does not hold the task under way any more; empty if it does.
        is_taken_over: whether another cell has taken over that task.
        is_overdue: whether the run's time limit has passed.
        unrested: servers that were lost during an operation, and may still complete it.
    """

    disowned: str = ""
    lost_lease: str = ""
    is_taken_over: bool = False
    is_overdue: bool = False
    unrested: tuple[str, ...] = ()


def decide_halt(state: RunState, now: Circumstances) -> str:
    """Return why what runs is to be stopped; empty if it is not."""
    task = state.tasks.get(state.current)
    is_attempt = task is not None and task.stage is Stage.RUNNING and task.part.is_attempt
    skipped_by = state.skipped.get(state.current, "") if is_attempt else ""
    return (
        now.disowned
        or (f"protective stop by {state.protective}" if state.protective else "")
        or state.stop
        or now.lost_lease
        or (task.halt if task else "")
        or (f"{skipped_by} skipped the task" if skipped_by else "")
        or ("the run's time limit has passed" if now.is_overdue else "")
    )


def decide_hold(state: RunState, now: Circumstances) -> str:
    """Return why nothing new may begin; empty if it may."""
    if state.paused:
        return "the run is paused"
    return f"not at rest: {', '.join(now.unrested)}" if now.unrested else ""


def is_cut_short(state: RunState, task: str, halted: str, now: Circumstances) -> bool:
    """Return whether a behavior was stopped by something other than a stop or a skip.

    What stopped it may be over by now: a protective stop can be released at once.

    Args:
        state: of the run.
        task: name of the behavior's task.
        halted: why the gate stopped the behavior; empty if it did not.
        now: what closes the gate besides the state.
    """
    if now.disowned or now.lost_lease or state.protective:
        return True
    is_asked_for = bool(state.stop) or task in state.skipped
    return bool(halted) and not is_asked_for


def cut_short_event(task: str, halted: str, now: Circumstances) -> TaskElsewhere | Interrupted:
    """Return what records that a behavior was cut short; what it has done is unverified."""
    return TaskElsewhere(task, "", AsLeft.RUNNING) if now.is_taken_over else Interrupted(halted)


def late_stop_event(state: RunState, operation: Operation) -> StopReported | Blocked | None:
    """Return what records an operation of an earlier behavior that a person is to answer first.

    Returns:
        None if the run knows of the operation.
    """
    task = state.tasks.get(state.current)
    if task is None:
        because = f"{operation.ability} ended with error {operation.error_code}: {operation.text}"
        return Blocked(f"{because}; a person is needed")
    known = (*task.operations, *filter(None, [task.stopped_by]))
    stops = [each.goal_id for each in known if each.error_code in PERSON_FIRST]
    return None if operation.goal_id in stops else StopReported(task.name, operation)
