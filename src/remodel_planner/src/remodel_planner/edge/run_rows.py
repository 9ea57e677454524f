"""The tables of a run that are made for questions: executions, their operations, and decisions.

They follow from the events, and change in the same transactions.
"""

from __future__ import annotations

from sqlalchemy import insert, select
from sqlalchemy.orm import Session

from remodel_planner.core.supervision.attempts import INTERRUPTED
from remodel_planner.core.supervision.events import (
    Decided,
    Event,
    OperationEnded,
    RunEnded,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_planner.core.supervision.state import RunState, Stage, TaskProgress
from remodel_planner.edge.database_errors import record_lost
from remodel_planner.edge.production_database import task_row
from remodel_planner.edge.production_models import (
    AbilityRecordRow,
    DecisionRow,
    ExecutionRow,
    RunEventRow,
    RunRow,
    TaskRow,
)

_OPERATION = OperationEnded.__name__
_STORED = {Stage.DONE: "done", Stage.SET_ASIDE: "set aside"}


def project(session: Session, run: int, event: Event, before: RunState, after: RunState) -> None:
    """Bring the tables up to date with an event.

    Args:
        session: with the transaction that keeps the event.
        run: number of the run.
        event: that happened.
        before: the state in which it happened.
        after: the state after it.
    """
    # What other cells do with a task is theirs to keep.
    if not isinstance(event, TaskElsewhere | TaskReturned):
        for name in _touched(event, before):
            stage, stage_before = after.tasks[name].stage, before.tasks[name].stage
            if stage is not stage_before and stage in _STORED:
                _end_task(_row_of(session, run, name), _STORED[stage], after.cell)
            elif stage is not stage_before and stage_before in _STORED:
                _reopen_task(_row_of(session, run, name), _STORED[stage_before], after.cell)
    current = before.tasks.get(before.current)
    if current is not None and current.stage is Stage.RUNNING:
        if isinstance(event, TaskEnded):
            end = (event.outcome, event.at_s, event.placed)
            _add_execution(session, run, current, *end)
        elif after.tasks[current.name].stage is not Stage.RUNNING:
            ended_s = max([current.began_s, *(o.ended_s for o in current.operations)])
            _add_execution(session, run, current, INTERRUPTED, ended_s, False)
    match event:
        case Decided():
            _add_decision(session, run, event)
        case RunEnded():
            session.get(RunRow, run).ended = True


def _touched(event: Event, before: RunState) -> set[str]:
    """Return the names of the tasks that an event may change."""
    names = {getattr(event, "task", ""), before.current}
    if before.question is not None:
        names.add(before.question.task)
    return names & before.tasks.keys()


def _end_task(row: TaskRow, state: str, cell: str) -> None:
    """Note that a cell has ended a task, unless another one has taken it over, or it is done."""
    if row.cell in ("", cell) and row.state != _STORED[Stage.DONE]:
        row.state, row.cell, row.lease_until = state, cell, None


def _reopen_task(row: TaskRow, state: str, cell: str) -> None:
    """Note that a task that had ended is to be done by a cell after all: it counts as begun."""
    if row.state == state:
        row.state, row.cell, row.lease_until = "begun", cell, None


def _row_of(session: Session, run: int, task: str) -> TaskRow:
    order = session.scalar(select(RunRow.order_id).where(RunRow.id == run))
    row = task_row(session, order, task)
    if row is None:
        raise record_lost(f"no longer has task {task} of run {run}")
    return row


def _add_execution(
    session: Session, run: int, task: TaskProgress, outcome: str, ended_s: float, placed: bool
) -> None:
    row = ExecutionRow(
        run_id=run,
        task_id=_row_of(session, run, task.name).id,
        behavior=task.behavior,
        attempt=task.attempts,
        outcome=outcome,
        placed=placed,
        started_s=task.began_s,
        ended_s=ended_s,
    )
    session.add(row)
    session.flush()
    positions = _operation_positions(session, run, len(task.operations))
    records = [
        {
            "execution_id": row.id,
            "state_path": operation.state_path,
            "ability": operation.ability,
            "outcome": operation.outcome,
            "error_code": operation.error_code,
            "ended_s": operation.ended_s,
            "elapsed_s": operation.elapsed_s,
            "position": position,
            "data": None,
        }
        for operation, position in zip(task.operations, positions, strict=True)
    ]
    if records:
        session.execute(insert(AbilityRecordRow), records)


def _operation_positions(session: Session, run: int, count: int) -> list[int]:
    """Return the positions of the last operations of a run, in order."""
    last = session.scalars(
        select(RunEventRow.position)
        .where(RunEventRow.run_id == run, RunEventRow.kind == _OPERATION)
        .order_by(RunEventRow.position.desc())
        .limit(count)
    ).all()
    if len(last) != count:
        raise record_lost(f"has lost operations of run {run}")
    return sorted(last)


def _add_decision(session: Session, run: int, event: Decided) -> None:
    """Add a decision to the last execution of its task, unless that has one."""
    execution = session.scalar(
        select(ExecutionRow)
        .where(
            ExecutionRow.run_id == run,
            ExecutionRow.task_id == _row_of(session, run, event.task).id,
        )
        .order_by(ExecutionRow.id.desc())
        .limit(1)
    )
    if execution is not None and execution.decision is None:
        execution.decision = DecisionRow(
            fault=event.fault,
            error_code=event.code,
            evidence=event.text,
            response=event.do.value,
            because=event.because,
        )
