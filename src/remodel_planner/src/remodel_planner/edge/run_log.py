"""What happens in runs, kept: event by event, each committed before the next begins.

Beside the events, which say everything, stand tables that are made for questions: executions,
ability records and decisions, and the state of each task. They change in the same transaction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime

from sqlalchemy import exists, func, select, update
from sqlalchemy.orm import Session

from remodel_planner.core.learning.learned_responses import TriedResponse
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.attempts import INTERRUPTED
from remodel_planner.core.supervision.event_form import data_of, event_from, kind_of
from remodel_planner.core.supervision.events import (
    Decided,
    Event,
    Interrupted,
    RunBegun,
    RunEnded,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_planner.core.supervision.state import RunState, Stage, TaskProgress, applied
from remodel_planner.edge.cell_ownership import require_owner
from remodel_planner.edge.database_errors import record_lost
from remodel_planner.edge.production_database import ProductionDatabase, order_row
from remodel_planner.edge.production_models import (
    AbilityRecordRow,
    CellRow,
    DecisionRow,
    ExecutionRow,
    OrderRow,
    RunEventRow,
    RunRow,
    TaskRow,
    WireRow,
)
from remodel_planner.edge.recorded_lessons import recorded_responses
from remodel_planner.errors import OrderError, OwnerError, PlannerError

_STORED = {Stage.DONE: "done", Stage.SET_ASIDE: "set aside"}


@dataclass(frozen=True)
class RunHead:
    """A run, as lists show it.

    Attributes:
        started: wall time, UTC.
    """

    number: int
    order: str
    cell: str
    started: datetime
    ended: bool


@dataclass(frozen=True)
class KeptEvent:
    """An event as it was kept.

    Attributes:
        at: wall time, UTC.
    """

    at: datetime
    event: Event


class RunLog:
    """The runs of a database."""

    def __init__(self, database: ProductionDatabase) -> None:
        """Take the database that keeps them."""
        self._database = database

    def begin(self, event: RunBegun, owner: int, *, again: bool = False) -> tuple[int, RunBegun]:
        """Begin a run, and return its number and its first event, completed.

        Alone on its order, it tries again what was set aside. Beside runs of other cells it
        leaves all tasks as they are. The event is completed with the
        serial number, and whether wires of that product may be on its panel already.

        Args:
            event: its beginning.
            owner: token of the cell's ownership.
            again: wire the next product of the order; otherwise the current one, or the first.

        Raises:
            OrderError: if there is no such order, or other cells work on one to be done again.
            OwnerError: if another supervisor owns the cell now.
        """
        with self._database.transaction() as session:
            require_owner(session, event.cell, owner, lock=True)
            order = order_row(session, event.order, lock=True)
            others = session.scalars(
                select(RunRow.cell).where(
                    RunRow.order_id == order.id,
                    RunRow.ended.is_(False),
                    RunRow.cell != event.cell,
                )
            ).all()
            if again and others:
                raise OrderError(
                    f"order {event.order} cannot be done again: cell {others[0]} works on it"
                )
            states = {"set aside", "done", "begun"} if again else {"set aside"}
            if not others:
                session.execute(
                    update(TaskRow)
                    .where(TaskRow.order_id == order.id, TaskRow.state.in_(states))
                    .values(state="open", cell="", token=0, lease_until=None)
                )
            is_new = again or not order.units
            order.units += is_new
            serial = f"{order.name}-{order.units:04d}"
            row = RunRow(
                order_id=order.id,
                started=_now(),
                cell=event.cell,
                ended=False,
                owner=owner,
                events=1,
                serial=serial,
            )
            session.add(row)
            session.flush()
            completed = replace(event, serial=serial, keep_panel=not is_new)
            session.add(_event_row(row.id, 0, completed))
            return int(row.id), completed

    def take_up(self, run: int, owner: int) -> None:
        """Take up a run that has not ended: from now on only this owner adds events to it.

        Args:
            run: number of the run.
            owner: token of the ownership of its cell.

        Raises:
            OwnerError: if another supervisor owns the cell now, or the run has ended.
            RecordLostError: if the run is gone.
        """
        with self._database.transaction() as session:
            taken = session.execute(
                update(RunRow)
                .where(RunRow.id == run, RunRow.ended.is_(False), _owns_cell(owner))
                .values(owner=owner)
                .execution_options(synchronize_session=False)
            )
            if not taken.rowcount:
                raise _refusal(session, run, owner)

    def append(self, run: int, event: Event, before: RunState, owner: int) -> RunState:
        """Keep an event, and return the state after it.

        Args:
            run: number of the run.
            event: that happened.
            before: the state in which it happened.
            owner: token of the ownership of its cell.

        Raises:
            OwnerError: if another supervisor owns the run or the cell now; nothing is kept.
            LostError: if the database does not answer.
            RecordLostError: if the run is gone.
        """
        after = applied(event, before)
        with self._database.transaction() as session:
            counted = session.execute(
                update(RunRow)
                .where(
                    RunRow.id == run,
                    RunRow.owner == owner,
                    RunRow.ended.is_(False),
                    _owns_cell(owner),
                )
                .values(events=RunRow.events + 1)
                .execution_options(synchronize_session=False)
            )
            if not counted.rowcount:
                raise _refusal(session, run, owner)
            count = session.scalar(select(RunRow.events).where(RunRow.id == run))
            session.add(_event_row(run, count - 1, event))
            _project(session, run, event, before, after)
        return after

    def events(self, run: int, first: int = 0) -> tuple[KeptEvent, ...]:
        """Return what happened in a run, in order.

        Args:
            run: number of the run.
            first: how many events, from the first, are left out since they are known.

        Raises:
            OrderError: if there is no run of that number, or its events were not kept.
        """
        with self._database.reading() as session:
            rows = session.scalars(
                select(RunEventRow)
                .where(RunEventRow.run_id == run, RunEventRow.position >= first)
                .order_by(RunEventRow.position)
            )
            events = tuple(KeptEvent(row.at, event_from(row.kind, row.data)) for row in rows)
        if not events and not first:
            known = ", ".join(str(head.number) for head in self.heads()) or "none"
            raise OrderError(f"there is no record of run {run}; there are {known}")
        return events

    def heads(self) -> tuple[RunHead, ...]:
        """Return the runs of which there is a record, the latest first."""
        recorded = select(RunEventRow.run_id)
        with self._database.reading() as session:
            rows = session.execute(
                select(RunRow, OrderRow.name)
                .join(OrderRow, RunRow.order_id == OrderRow.id)
                .where(RunRow.id.in_(recorded))
                .order_by(RunRow.id.desc())
            )
            return tuple(
                RunHead(row.id, order, row.cell, row.started, row.ended) for row, order in rows
            )

    def tried_responses(self) -> tuple[TriedResponse, ...]:
        """Return what was done about faults in any run, and whether it helped."""
        with self._database.reading() as session:
            return recorded_responses(session)

    def unfinished(self, cell: str) -> int | None:
        """Return the number of a cell's run that has not ended; None if all have."""
        with self._database.reading() as session:
            return session.scalar(
                select(func.max(RunRow.id)).where(RunRow.cell == cell, RunRow.ended.is_(False))
            )


def kept_run(url: str, run: int) -> tuple[KeptEvent, ...]:
    """Return what happened in a run of the database at a URL.

    Raises:
        OrderError: if there is no such database, or no record of the run.
    """
    database = ProductionDatabase(url)
    try:
        return RunLog(database).events(run)
    finally:
        database.close()


def _owns_cell(owner: int) -> object:
    """Return the condition that the cell of a run has this owner."""
    return exists().where(CellRow.name == RunRow.cell, CellRow.token == owner)


def _refusal(session: Session, run: int, owner: int) -> PlannerError:
    """Return why nothing can be added to a run."""
    row = session.get(RunRow, run)
    if row is None:
        return record_lost(f"no longer has run {run}")
    require_owner(session, row.cell, owner)
    if row.ended:
        return OwnerError(f"run {run} has ended: nothing can be added to it")
    return OwnerError(
        f"run {run} belongs to another owner of cell {row.cell} (token {row.owner}; this one has "
        f"{owner}): take it up first"
    )


def _event_row(run: int, position: int, event: Event) -> RunEventRow:
    return RunEventRow(
        run_id=run, position=position, at=_now(), kind=kind_of(event), data=data_of(event)
    )


def _project(session: Session, run: int, event: Event, before: RunState, after: RunState) -> None:
    """Bring the tables that are made for questions up to date."""
    # What other cells do with a task is theirs to keep.
    if not isinstance(event, TaskElsewhere | TaskReturned):
        for name in _touched(event, before):
            stage = after.tasks[name].stage
            if stage is not before.tasks[name].stage and stage in _STORED:
                _end_task(_task_row(session, run, name), _STORED[stage], after.cell)
    current = before.tasks.get(before.current)
    match event:
        case TaskEnded():
            session.add(
                _execution_row(session, run, current, event.outcome, event.at_s, event.placed)
            )
        case Interrupted() if current is not None and current.stage is Stage.RUNNING:
            ended_s = max([current.began_s, *(o.ended_s for o in current.operations)])
            session.add(_execution_row(session, run, current, INTERRUPTED, ended_s, False))
        case Decided():
            execution = session.scalar(
                select(ExecutionRow)
                .where(
                    ExecutionRow.run_id == run,
                    ExecutionRow.task_id == _task_row(session, run, event.task).id,
                )
                .order_by(ExecutionRow.id.desc())
                .limit(1)
            )
            if execution is not None and execution.decision is None:
                execution.decision = _decision_row(event)
        case RunEnded():
            session.get(RunRow, run).ended = True


def _touched(event: Event, before: RunState) -> set[str]:
    """Return the names of the tasks that an event may change."""
    names = {getattr(event, "task", ""), before.current}
    if before.question is not None:
        names.add(before.question.task)
    return names & before.tasks.keys()


def _end_task(row: TaskRow, state: str, cell: str) -> None:
    """Note that a cell has ended a task, unless another one has taken it over."""
    if row.cell in ("", cell):
        row.state, row.cell, row.lease_until = state, cell, None


def _task_row(session: Session, run: int, task: str) -> TaskRow:
    row = session.scalar(
        select(TaskRow)
        .join(WireRow, TaskRow.wire_id == WireRow.id)
        .join(RunRow, RunRow.order_id == TaskRow.order_id)
        .where(RunRow.id == run, WireRow.name == task)
    )
    if row is None:
        raise record_lost(f"no longer has task {task} of run {run}")
    return row


def _execution_row(
    session: Session, run: int, task: TaskProgress, outcome: str, ended_s: float, placed: bool
) -> ExecutionRow:
    return ExecutionRow(
        run_id=run,
        task_id=_task_row(session, run, task.name).id,
        behavior=task.behavior,
        attempt=task.attempts,
        outcome=outcome,
        placed=placed,
        started_s=task.began_s,
        ended_s=ended_s,
        operations=[_record_row(operation) for operation in task.operations],
    )


def _record_row(operation: Operation) -> AbilityRecordRow:
    return AbilityRecordRow(
        state_path=operation.state_path,
        ability=operation.ability,
        outcome=operation.outcome,
        error_code=operation.error_code,
        text=operation.text,
        ended_s=operation.ended_s,
        elapsed_s=operation.elapsed_s,
        goal_id=operation.goal_id,
        parameters=[list(pair) for pair in operation.parameters],
        measurements=[list(pair) for pair in operation.measurements],
    )


def _decision_row(event: Decided) -> DecisionRow:
    return DecisionRow(
        fault=event.fault,
        error_code=event.code,
        evidence=event.text,
        response=event.do.value,
        because=event.because,
    )


def _now() -> datetime:
    return datetime.now(UTC).replace(tzinfo=None)
