"""What is known of a wire: its task, and what has happened to it in this run."""

from __future__ import annotations

from remodel_console.core.use_case.record import Record, value_words
from remodel_console.core.use_case.use_case import UseCase, duration_words
from remodel_run.record import Kind, decision_words, entry_words, fault_words


def wire_words(wire: str, use_case: UseCase | None) -> tuple[str, ...]:
    """Return lines about a wire: its task's state, then its failures, the latest first."""
    task = next((t for t in use_case.tasks if t.name == wire), None) if use_case else None
    if task is None or use_case is None:
        return ("No task of the present order is about this wire.",)
    attempts = f", {task.attempts} attempt{'s' * (task.attempts != 1)}" if task.attempts else ""
    taken = f", {duration_words(task.taken_s)}" if task.taken_s else ""
    lines = [task.description, f"{task.words}{attempts}{taken}"]
    for failure in reversed(use_case.failures):
        if failure.task == wire:
            then = decision_words(failure.decision)
            lines.append(f"{fault_words(failure.fault)}: {failure.text}; the cell {then}.")
    return tuple(filter(None, lines))


def force_words(record: Record, wire: str, last: int | None = None) -> tuple[str, ...]:
    """Return a line for each force that was measured while a wire was under way.

    Args:
        record: of the run.
        wire: name of the wire, as of its task.
        last: index of the last entry that counts; None: all do.
    """
    entries = record.entries if last is None else record.entries[: last + 1]
    forces: dict[str, list[float]] = {}
    for entry in entries:
        if entry.task == wire:
            for name, value in entry.values:
                if name.endswith("_n"):
                    forces.setdefault(name, []).append(value)
    return tuple(
        f"{value_words(name)}: {max(values):.3g} at most, {values[-1]:.3g} last"
        for name, values in forces.items()
    )


def recorded_wire_words(record: Record, wire: str, last: int) -> tuple[str, ...]:
    """Return lines about a wire at a moment of a replayed run, the latest of its history first.

    Args:
        record: of the run.
        wire: name of the wire, as of its task.
        last: index of the entry that happened last.
    """
    own = [e for e in record.entries[: last + 1] if e.task == wire]
    if not own:
        will = any(entry.task == wire for entry in record.entries)
        return ("Its task begins later in this run." if will else "No task is about this wire.",)
    shown = (Kind.TASK, Kind.FAILURE, Kind.DECISION, Kind.OPERATOR)
    history = [e for e in own if e.kind in shown]
    lines = (f"{record.offset_s(e):.1f} s: {entry_words(e)}" for e in reversed(history))
    return (*force_words(record, wire, last), *lines)
