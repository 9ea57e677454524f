"""What is known of a wire: its task, and what has happened to it in this run."""

from __future__ import annotations

from remodel_console.core.use_case.use_case import (
    TaskPhase,
    UseCase,
    decision_words,
    duration_words,
    fault_words,
)

PHASE_WORDS = {
    TaskPhase.WAITING: "waiting",
    TaskPhase.RUNNING: "running",
    TaskPhase.DONE: "done",
    TaskPhase.SET_ASIDE: "skipped",
}


def wire_words(wire: str, use_case: UseCase | None) -> tuple[str, ...]:
    """Return lines about a wire: its task's state, then its failures, the latest first."""
    task = next((t for t in use_case.tasks if t.name == wire), None) if use_case else None
    if task is None or use_case is None:
        return ("No task of the present order is about this wire.",)
    attempts = f", {task.attempts} attempt{'s' * (task.attempts != 1)}" if task.attempts else ""
    taken = f", {duration_words(task.taken_s)}" if task.taken_s else ""
    lines = [task.description, f"{PHASE_WORDS[task.phase]}{attempts}{taken}"]
    for failure in reversed(use_case.failures):
        if failure.task == wire:
            then = decision_words(failure.decision)
            lines.append(f"{fault_words(failure.fault)}: {failure.text}; the cell {then}.")
    return tuple(filter(None, lines))
