"""What a supervisor does next, for a state. Pure: the same state gives the same step."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_run.whole_task import counted
from remodel_supervision.core.runs.events import Ending, Part
from remodel_supervision.core.runs.state import RunState, Stage

# Wires by hand that the end of a run names.
_SHOWN_WIRES = 10


@dataclass(frozen=True)
class Plan:
    """Decide the order of the waiting tasks."""

    because: str


@dataclass(frozen=True)
class Execute:
    """Run a behavior of a task."""

    task: str
    part: Part


@dataclass(frozen=True)
class Settle:
    """Inspect what of a task is done."""

    task: str


@dataclass(frozen=True)
class Decide:
    """Decide what to do about a task that failed."""

    task: str


@dataclass(frozen=True)
class Ask:
    """Ask an operator about a task."""

    task: str


@dataclass(frozen=True)
class Wait:
    """Wait for an operator, or for other cells."""

    why: str


@dataclass(frozen=True)
class EndRun:
    """End the run."""

    ending: Ending
    because: str


def description_of(step: Step) -> str:
    """Return what a step does, for a person."""
    match step:
        case Plan():
            return f"deciding the order of the tasks: {step.because}"
        case Execute():
            return f"{step.task}: {_PARTS[step.part]}"
        case Settle():
            return f"{step.task}: inspecting what of it is done"
        case Decide():
            return f"{step.task}: deciding what to do about its failure"
        case Ask():
            return f"{step.task}: asking the operator"
        case Wait():
            return f"waiting: {step.why}"
        case EndRun():
            return f"ending: {step.because}"


_PARTS = {
    Part.WHOLE: "placing a new wire",
    Part.AGAIN: "placing the wire again",
    Part.REST: "finishing what is left of it",
    Part.CLEAR: "emptying the hand",
    Part.DISCARD: "discarding the wire",
}

Step = Plan | Execute | Settle | Decide | Ask | Wait | EndRun


def next_step(state: RunState) -> Step | None:
    """Return what comes next; None if the run has ended.

    A supervisor that takes a run up records first that it was interrupted, so that a behavior of
    which it knows nothing does not count as running.
    """
    if state.ended is not None:
        return None
    if state.stop:
        return EndRun(Ending.STOPPED, state.stop)
    if state.current:
        return _about(state, state.current)
    if state.paused:
        return Wait(_why_paused(state))
    if state.to_plan and state.waiting:
        return Plan(state.to_plan)
    if state.waiting:
        task = state.tasks[state.waiting[0]]
        return (
            Settle(task.name) if task.stage is Stage.UNVERIFIED else Execute(task.name, task.part)
        )
    if elsewhere := state.in_stage(Stage.ELSEWHERE):
        return Wait(f"other cells have {', '.join(elsewhere)}")
    aside = state.in_stage(Stage.SET_ASIDE)
    if aside:
        return EndRun(Ending.INCOMPLETE, f"skipped: {', '.join(aside)}{_by_hand(state)}")
    of_cell = " of the cell" if state.by_hand else ""
    return EndRun(Ending.COMPLETE, f"all tasks{of_cell} are done{_by_hand(state)}")


def _by_hand(state: RunState) -> str:
    """Return which wires are left to a person; empty if none is."""
    names = [wire.name for wire in state.by_hand]
    if not names:
        return ""
    more = f" and {len(names) - _SHOWN_WIRES} more" if len(names) > _SHOWN_WIRES else ""
    shown = ", ".join(names[:_SHOWN_WIRES])
    return f"; still to be placed by hand: {counted(len(names), 'wire')}, {shown}{more}"


def _why_paused(state: RunState) -> str:
    if state.protective:
        return f"protective stop by {state.protective}; release it, then resume the run"
    return "paused by an operator"


def _about(state: RunState, name: str) -> Step:
    task = state.tasks[name]
    match task.stage:
        case Stage.RUNNING:
            return Wait(f"the behavior of {name} runs")
        case Stage.FAILED:
            return Decide(name)
        case Stage.ASKING if state.question is None:
            return Ask(name)
        case Stage.ASKING:
            return Wait(f"question {state.questions} is to be answered")
    if state.paused:
        return Wait(_why_paused(state))
    if task.stage is Stage.UNVERIFIED:
        return Settle(name)
    return Execute(name, task.part)


_ITEM = "  - "

# How many problems are shown; those of one cause often come in rows.
SHOWN = 3


def abridged(text: str, shown: int = SHOWN) -> str:
    """Return a text whose list of problems (lines that begin with `  - `) is cut after some."""
    lines = text.splitlines()
    items = [index for index, line in enumerate(lines) if line.startswith(_ITEM)]
    cut = items[shown:]
    if len(cut) < 2:
        return text
    kept = [line for index, line in enumerate(lines) if index not in cut[1:]]
    kept[cut[0]] = f"{_ITEM}and {len(cut)} more"
    return "\n".join(kept)
