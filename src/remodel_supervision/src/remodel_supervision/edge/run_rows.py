"""Events as rows, and the tables that are made for questions: executions, operations, decisions.

Charts are stored once, beside the events that name them. The tables follow from the events, and
change in the same transactions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

from sqlalchemy import bindparam, insert, select, text
from sqlalchemy.engine import Connection

from remodel_production.edge.database.production_database import TASKS, record_lost
from remodel_production.edge.database.production_models import (
    AbilityRecordRow,
    ChartRow,
    DecisionRow,
    ExecutionRow,
    OrderRow,
    RunEventRow,
    RunRow,
    WireRow,
    packed,
)
from remodel_supervision.core.runs.attempts import INTERRUPTED
from remodel_supervision.core.runs.events import (
    Decided,
    Event,
    OperationEnded,
    RunEnded,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
    data_of,
    event_from,
    kind_of,
)
from remodel_supervision.core.runs.state import RunState, Stage, TaskProgress

_CHART, _HASH = "chart", "chart_hash"

_ADD = insert(RunEventRow)
_BETWEEN = (
    select(RunEventRow.at, RunEventRow.kind, RunEventRow.data)
    .where(
        RunEventRow.run_id == bindparam("run"),
        RunEventRow.position >= bindparam("first"),
        RunEventRow.position < bindparam("end"),
    )
    .order_by(RunEventRow.position)
)
_CHART_HASH = select(ChartRow.hash).where(ChartRow.hash == bindparam("hash"))
# Another cell may store it at the same moment.
_ADD_CHART = text(
    "INSERT INTO charts (hash, xml) VALUES (:hash, :xml) ON CONFLICT (hash) DO NOTHING"
)


@dataclass(frozen=True)
class KeptEvent:
    """An event as it was kept.

    Attributes:
        at: wall time, UTC.
    """

    at: datetime
    event: Event


def add_event(connection: Connection, run: int, position: int, event: Event) -> None:
    """Add an event to a run.

    Args:
        connection: with a transaction.
        run: number of the run.
        position: of the event in the run, from 0.
        event: that happened.
    """
    data = data_of(event)
    if isinstance(event, TaskBegun):
        del data[_CHART]
        data[_HASH] = _stored_chart(connection, event.chart)
    row = {"run_id": run, "position": position, "at": now(), "kind": kind_of(event), "data": data}
    connection.execute(_ADD, row)


def events_between(
    connection: Connection, run: int, first: int, end: int, *, charts: bool
) -> Iterator[KeptEvent]:
    """Yield the events of a run at some positions.

    Args:
        connection: to read with.
        run: number of the run.
        first: position of the first event.
        end: position after the last event.
        charts: whether the charts are read; without, they are empty.

    Raises:
        RecordLostError: if an event or a chart is missing.
    """
    rows = connection.execute(_BETWEEN, {"run": run, "first": first, "end": end}).all()
    if len(rows) != end - first:
        raise record_lost(
            f"has {len(rows)} of the {end - first} events of run {run} from number {first} on"
        )
    hashes = {row.data[_HASH] for row in rows if _HASH in row.data}
    xml_of = _charts(connection, hashes) if charts else dict.fromkeys(hashes, "")
    for at, kind, data in rows:
        if _HASH in data:
            data[_CHART] = xml_of[data.pop(_HASH)]
        yield KeptEvent(at, event_from(kind, data))


def now() -> datetime:
    """Return the wall time, UTC, as it is stored."""
    return datetime.now(UTC).replace(tzinfo=None)


def _stored_chart(connection: Connection, xml: str) -> str:
    """Store a chart unless it is there, and return its hash."""
    digest = hashlib.sha256(xml.encode()).hexdigest()
    if connection.scalar(_CHART_HASH, {"hash": digest}) is None:
        connection.execute(_ADD_CHART, {"hash": digest, "xml": packed(xml)})
    return digest


def _charts(connection: Connection, hashes: Collection[str]) -> dict[str, str]:
    found = select(ChartRow.hash, ChartRow.xml).where(ChartRow.hash.in_(hashes))
    xml_of = {digest: xml for digest, xml in connection.execute(found)} if hashes else {}
    missing = set(hashes) - xml_of.keys()
    if missing:
        raise record_lost(f"has no chart {min(missing)}")
    return xml_of


_OPERATION = OperationEnded.__name__
_STORED = {Stage.DONE: "done", Stage.SET_ASIDE: "set aside"}

_TASK = TASKS.join(RunRow, RunRow.order_id == OrderRow.id).where(
    RunRow.id == bindparam("run"), WireRow.name == bindparam("task")
)
# A task stays as it is if another cell has taken it over, or it is done.
_END_TASK = text(
    "UPDATE tasks SET state = :state, cell = :cell, lease_until = NULL "
    "WHERE id = :task AND cell IN ('', :cell) AND state <> 'done'"
)
# A task that had ended is to be done by a cell after all: it counts as begun.
_REOPEN_TASK = text(
    "UPDATE tasks SET state = 'begun', cell = :cell, lease_until = NULL "
    "WHERE id = :task AND state = :state"
)
_ADD_EXECUTION = insert(ExecutionRow)
_ADD_RECORD = insert(AbilityRecordRow)
_ADD_DECISION = insert(DecisionRow)
_END_RUN = text("UPDATE runs SET ended = :ended WHERE id = :run")
_LAST_OPERATIONS = (
    select(RunEventRow.position)
    .where(RunEventRow.run_id == bindparam("run"), RunEventRow.kind == _OPERATION)
    .order_by(RunEventRow.position.desc())
    .limit(bindparam("count"))
)
# The last execution of a task, and what was decided about it.
_LAST_EXECUTION = (
    select(ExecutionRow.id, DecisionRow.id.label("decision"))
    .outerjoin(DecisionRow, DecisionRow.execution_id == ExecutionRow.id)
    .where(ExecutionRow.run_id == bindparam("run"), ExecutionRow.task_id == bindparam("task"))
    .order_by(ExecutionRow.id.desc())
    .limit(1)
)


def project(
    connection: Connection, run: int, event: Event, before: RunState, after: RunState
) -> None:
    """Bring the tables up to date with an event.

    Args:
        connection: with the transaction that keeps the event.
        run: number of the run.
        event: that happened.
        before: the state in which it happened.
        after: the state after it.
    """
    # What other cells do with a task is theirs to keep.
    if not isinstance(event, TaskElsewhere | TaskReturned):
        for name in _touched(event, before):
            _end_or_reopen(connection, run, before.tasks[name], after)
    current = before.tasks.get(before.current)
    if current is not None and current.stage is Stage.RUNNING:
        if isinstance(event, TaskEnded):
            end = (event.outcome, event.at_s, event.placed)
            _add_execution(connection, run, current, *end)
        elif after.tasks[current.name].stage is not Stage.RUNNING:
            ended_s = max([current.began_s, *(o.ended_s for o in current.operations)])
            _add_execution(connection, run, current, INTERRUPTED, ended_s=ended_s, placed=False)
    match event:
        case Decided():
            _add_decision(connection, run, event)
        case RunEnded():
            connection.execute(_END_RUN, {"run": run, "ended": True})


def _touched(event: Event, before: RunState) -> set[str]:
    """Return the names of the tasks that an event may change."""
    names = {getattr(event, "task", ""), before.current}
    if before.question is not None:
        names.add(before.question.task)
    return names & before.tasks.keys()


def _end_or_reopen(connection: Connection, run: int, before: TaskProgress, after: RunState) -> None:
    """Note that a task has ended, or is to be done after all."""
    stage = after.tasks[before.name].stage
    if stage is before.stage:
        return
    if stage in _STORED:
        change, state = _END_TASK, _STORED[stage]
    elif before.stage in _STORED:
        change, state = _REOPEN_TASK, _STORED[before.stage]
    else:
        return
    task = _task_number(connection, run, before.name)
    connection.execute(change, {"task": task, "state": state, "cell": after.cell})


def _task_number(connection: Connection, run: int, task: str) -> int:
    number = connection.scalar(_TASK, {"run": run, "task": task})
    if number is None:
        raise record_lost(f"no longer has task {task} of run {run}")
    return int(number)


def _add_execution(
    connection: Connection,
    run: int,
    task: TaskProgress,
    outcome: str,
    ended_s: float,
    placed: bool,
) -> None:
    values = {
        "run_id": run,
        "task_id": _task_number(connection, run, task.name),
        "behavior": task.behavior,
        "attempt": task.attempts,
        "outcome": outcome,
        "placed": placed,
        "started_s": task.began_s,
        "ended_s": ended_s,
    }
    (number,) = connection.execute(_ADD_EXECUTION, values).inserted_primary_key
    if not task.operations:
        return
    positions = _operation_positions(connection, run, len(task.operations))
    records = [
        {
            "execution_id": number,
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
    connection.execute(_ADD_RECORD, records)


def _operation_positions(connection: Connection, run: int, count: int) -> list[int]:
    """Return the positions of the last operations of a run, in order."""
    last = connection.scalars(_LAST_OPERATIONS, {"run": run, "count": count}).all()
    if len(last) != count:
        raise record_lost(f"has lost operations of run {run}")
    return sorted(last)


def _add_decision(connection: Connection, run: int, event: Decided) -> None:
    """Add a decision to the last execution of its task, unless that has one."""
    asked = {"run": run, "task": _task_number(connection, run, event.task)}
    last = connection.execute(_LAST_EXECUTION, asked).first()
    if last is None or last.decision is not None:
        return
    values = {
        "execution_id": last.id,
        "fault": event.fault,
        "error_code": event.code,
        "evidence": event.text,
        "response": event.do.value,
        "because": event.because,
    }
    connection.execute(_ADD_DECISION, values)
