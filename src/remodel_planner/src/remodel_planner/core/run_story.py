"""A recorded run in words: what was done, what failed, what was decided about it and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from remodel_planner.core.recovery.fault import FaultTable
from remodel_planner.core.run import Execution
from remodel_planner.core.run_report import failure_line


@dataclass(frozen=True)
class KeptDecision:
    """What was decided about a failure, as it was kept.

    Attributes:
        fault: name of its kind.
        evidence: what the ability, or the engine, said.
        response: what was done, a value of recovery.fault.Do.
        because: the reason.
    """

    fault: str
    evidence: str
    response: str
    because: str


@dataclass(frozen=True)
class Attempt:
    """An execution, and what was decided about it if it failed."""

    execution: Execution
    decision: KeptDecision | None


@dataclass(frozen=True)
class RunRecord:
    """A run as the production database has it.

    Attributes:
        number: of the run.
        order: name of the order.
        started: wall time, UTC.
    """

    number: int
    order: str
    started: datetime
    attempts: tuple[Attempt, ...]


def tell(run: RunRecord, faults: FaultTable) -> Iterator[str]:
    """Yield the lines of a run's story."""
    wires = dict.fromkeys(attempt.execution.wire for attempt in run.attempts)
    yield (
        f"run {run.number} of order {run.order}, begun {run.started:%Y-%m-%d %H:%M:%S} UTC: "
        f"{_count(len(wires), 'wire')}, {_count(len(run.attempts), 'attempt')}"
    )
    for attempt in run.attempts:
        yield from _attempt(attempt, faults)
    lost = [wire for wire in wires if not _is_placed(run, wire)]
    end = f"not placed: {' '.join(lost)}" if lost else "all are placed"
    yield f"{len(wires) - len(lost)} of {_count(len(wires), 'wire')} placed; {end}"


def _attempt(attempt: Attempt, faults: FaultTable) -> Iterator[str]:
    execution, decision = attempt.execution, attempt.decision
    yield (
        f"{execution.wire}, attempt {execution.attempt}: {execution.behavior} ended "
        f"{execution.outcome} after {execution.cell_s:.1f} s and "
        f"{_count(len(execution.operations), 'operation')}; the wire is "
        f"{'placed' if execution.placed else 'not placed'}"
    )
    for failure in execution.failures:
        yield f"    {failure.state_path}: {failure_line(failure)}"
    if decision is None:
        if execution.failures:
            yield "    the behavior itself put it right"
        return
    symptoms = faults[decision.fault].symptoms if decision.fault in faults.names else ""
    yield f"    it was {decision.fault}. {symptoms}".rstrip()
    yield f"    so: {decision.response.replace('_', ' ')}, since {decision.because}"


def _is_placed(run: RunRecord, wire: str) -> bool:
    return any(a.execution.placed for a in run.attempts if a.execution.wire == wire)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
