"""What happens in runs, kept: event by event, each committed before the next begins.

Beside the events, which say everything, stand tables that are made for questions: executions,
ability records and decisions, and the state of each task. They change in the same transaction.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import datetime

from sqlalchemy import bindparam, func, insert, select, text, update
from sqlalchemy.engine import Connection

from remodel_production.edge.database.cell_ownership import require_owner
from remodel_production.edge.database.production_database import (
    ProductionDatabase,
    order_row,
    record_lost,
)
from remodel_production.edge.database.production_models import (
    OrderRow,
    RunEventRow,
    RunRow,
    RunSnapshotRow,
    TaskRow,
    WireRow,
    packed_json,
)
from remodel_production.errors import OrderError, OwnerError, PlannerError
from remodel_supervision.core.learning.experience import TriedResponse
from remodel_supervision.core.runs.event_table import apply_event, state_after
from remodel_supervision.core.runs.events import Event, PanelLoaded, RunBegun
from remodel_supervision.core.runs.state import RunState, snapshot_of, state_from
from remodel_supervision.edge.recorded_lessons import recorded_responses
from remodel_supervision.edge.run_rows import KeptEvent, add_event, events_between, now, project

# After how many events the state of a run is kept, and how many are read at once.
SNAPSHOT_EVERY = 500
_READ_AT_ONCE = 1000

# How many serial numbers an error names.
_SHOWN = 10

_RUN = select(RunRow).where(RunRow.id == bindparam("run"))
_HEADS = (
    select(RunRow.id, OrderRow.name, RunRow.cell, RunRow.started, RunRow.ended, RunRow.serial)
    .join(OrderRow, RunRow.order_id == OrderRow.id)
    .where(RunRow.events > 0)
    .order_by(RunRow.id)
)
_HEADS_OF_PRODUCT = _HEADS.where(RunRow.serial == bindparam("serial"))
_UNFINISHED = select(func.max(RunRow.id)).where(
    RunRow.cell == bindparam("cell"), RunRow.ended.is_(False)
)
# The last run of a product whose panel was built.
_LOADED = (
    select(RunRow.id)
    .join(RunEventRow, RunEventRow.run_id == RunRow.id)
    .where(RunRow.serial == bindparam("serial"), RunEventRow.kind == PanelLoaded.__name__)
    .order_by(RunRow.id.desc())
    .limit(1)
)
_DONE = (
    select(WireRow.name)
    .join(TaskRow, TaskRow.wire_id == WireRow.id)
    .where(TaskRow.order_id == bindparam("order"), TaskRow.state == "done")
)
_SNAPSHOT = select(RunSnapshotRow).where(RunSnapshotRow.run_id == bindparam("run"))

# One statement each, so that no other owner can come between the check and the change.
_OWNS_CELL = "EXISTS (SELECT 1 FROM cells WHERE cells.name = runs.cell AND cells.token = :owner)"
_TAKE_UP = text(f"UPDATE runs SET owner = :owner WHERE id = :run AND NOT ended AND {_OWNS_CELL}")
_COUNT_EVENT = text(
    "UPDATE runs SET events = events + 1 WHERE id = :run AND owner = :owner AND NOT ended AND "
    f"events = :events AND {_OWNS_CELL} RETURNING events"
)
_STORE_SNAPSHOT = text(
    "INSERT INTO run_snapshots (run_id, events, data) VALUES (:run, :events, :data) "
    "ON CONFLICT (run_id) DO UPDATE SET events = excluded.events, data = excluded.data"
)


@dataclass(frozen=True)
class RunHead:
    """A run, as lists show it.

    Attributes:
        started: wall time, UTC.
        serial: number of the product; empty if not known.
    """

    number: int
    order: str
    cell: str
    started: datetime
    ended: bool
    serial: str = ""


class RunLog:
    """The runs of a database."""

    def __init__(self, database: ProductionDatabase) -> None:
        """Take the database that keeps them."""
        self._database = database

    def begin(self, event: RunBegun, owner: int, *, again: bool = False) -> tuple[int, RunBegun]:
        """Begin a run, and return its number and its first event, completed.

        If no other cell works on the order, the tasks that were skipped are tried again; otherwise
        all tasks stay as they are. The event is completed with the serial number, whether wires of
        that product may be on its panel already, and which of its tasks are done.

        Args:
            event: its beginning.
            owner: token of the cell's ownership.
            again: wire the next product of the order; otherwise the current one, or the first.

        Raises:
            OrderError: if there is no such order, other cells work on one to be done again, or the
                product is on the panel of another use case.
            OwnerError: if another supervisor owns the cell now.
        """
        with self._database.transaction() as connection:
            require_owner(connection, event.cell, owner, lock=True)
            order = order_row(connection, event.order, lock=True)
            others = connection.scalars(
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
                connection.execute(
                    update(TaskRow)
                    .where(TaskRow.order_id == order.id, TaskRow.state.in_(states))
                    .values(state="open", cell="", token=0, lease_until=None)
                )
            is_new = again or not order.units
            units = order.units + is_new
            connection.execute(update(OrderRow).where(OrderRow.id == order.id).values(units=units))
            done = frozenset(connection.scalars(_DONE, {"order": order.id}))
            completed = replace(
                event,
                serial=f"{order.name}-{units:04d}",
                keep_panel=not is_new,
                done=tuple(name for name in event.tasks if name in done),
            )
            _require_same_use_case(connection, completed)
            values = {
                "order_id": order.id,
                "started": now(),
                "cell": event.cell,
                "ended": False,
                "owner": owner,
                "events": 1,
                "serial": completed.serial,
            }
            (number,) = connection.execute(insert(RunRow), values).inserted_primary_key
            add_event(connection, number, 0, completed)
            return int(number), completed

    def take_up(self, run: int, owner: int) -> None:
        """Take up a run that has not ended: from now on only this owner adds events to it.

        Args:
            run: number of the run.
            owner: token of the ownership of its cell.

        Raises:
            OwnerError: if another supervisor owns the cell now, or the run has ended.
            RecordLostError: if the run is gone.
        """
        with self._database.transaction() as connection:
            taken = connection.execute(_TAKE_UP, {"run": run, "owner": owner})
            if not taken.rowcount:
                raise _refusal(connection, run, owner)

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
            RecordLostError: if the run is gone, or has not the events that led to `before`.
        """
        after = apply_event(event, before)
        with self._database.transaction() as connection:
            asked = {"run": run, "owner": owner, "events": before.events}
            count = connection.scalar(_COUNT_EVENT, asked)
            if count is None:
                raise _refusal(connection, run, owner, before.events)
            add_event(connection, run, count - 1, event)
            project(connection, run, event, before, after=after)
            if count % SNAPSHOT_EVERY == 0:
                _store_snapshot(connection, run, count, after)
        return after

    def events(self, run: int, first: int = 0, *, charts: bool = True) -> Iterator[KeptEvent]:
        """Return what happened in a run, in order; it is read while the iterator is used.

        Args:
            run: number of the run.
            first: how many events, from the first, are left out since they are known.
            charts: whether charts are read; without, they are empty.

        Raises:
            OrderError: if there is no run of that number, or its events were not kept.
            RecordLostError: if events of the run are gone.
        """
        return self._between(run, first, self._count(run), charts=charts)

    def state(self, run: int) -> RunState:
        """Return what is known of a run: its last snapshot, and what has happened since then.

        Raises:
            OrderError: if there is no run of that number, or its events were not kept.
            RecordLostError: if events of the run are gone.
        """
        count = self._count(run)
        with self._database.reading() as connection:
            row = connection.execute(_SNAPSHOT, {"run": run}).first()
            state = state_from(row.data) if row is not None else None
            first = row.events if state is not None else 0
        tail = self._between(run, first, count, charts=False)
        return state_after((kept.event for kept in tail), state)

    def _count(self, run: int) -> int:
        """Return how many events a run has."""
        with self._database.reading() as connection:
            row = connection.execute(_RUN, {"run": run}).first()
        if row is None or not row.events:
            known = ", ".join(str(head.number) for head in self.heads()) or "none"
            raise OrderError(f"there is no record of run {run}; there are {known}")
        return int(row.events)

    def _between(self, run: int, first: int, end: int, *, charts: bool) -> Iterator[KeptEvent]:
        for start in range(first, end, _READ_AT_ONCE):
            stop = min(end, start + _READ_AT_ONCE)
            with self._database.reading() as connection:
                batch = list(events_between(connection, run, start, stop, charts=charts))
            yield from batch

    def heads(self) -> tuple[RunHead, ...]:
        """Return the runs of which there is a record, the latest first."""
        with self._database.reading() as connection:
            rows = connection.execute(_HEADS).all()
        return tuple(RunHead(*row) for row in reversed(rows))

    def runs_of(self, serial: str) -> tuple[RunHead, ...]:
        """Return the runs that wired a product, the first first.

        Raises:
            OrderError: if there is no product of that serial number.
        """
        with self._database.reading() as connection:
            rows = connection.execute(_HEADS_OF_PRODUCT, {"serial": serial}).all()
        if not serial or not rows:
            known = sorted({head.serial for head in self.heads()} - {""})
            shown = ", ".join(known[-_SHOWN:]) or "none"
            raise OrderError(f"there is no product {serial!r}; the last ones are: {shown}")
        return tuple(RunHead(*row) for row in rows)

    def tried_responses(self) -> tuple[TriedResponse, ...]:
        """Return what was done about faults in any run, and whether it helped."""
        with self._database.reading() as connection:
            return recorded_responses(connection)

    def unfinished(self, cell: str) -> int | None:
        """Return the number of a cell's run that has not ended; None if all have."""
        with self._database.reading() as connection:
            return connection.scalar(_UNFINISHED, {"cell": cell})


def kept_run(url: str, run: int) -> tuple[KeptEvent, ...]:
    """Return what happened in a run of the database at a URL.

    Raises:
        OrderError: if there is no such database, or no record of the run.
    """
    database = ProductionDatabase(url)
    try:
        return tuple(RunLog(database).events(run))
    finally:
        database.close()


def _require_same_use_case(connection: Connection, event: RunBegun) -> None:
    """Raise OrderError if the product is on a panel that another use case has laid out."""
    run = connection.scalar(_LOADED, {"serial": event.serial})
    if run is None:
        return
    (kept,) = events_between(connection, run, 0, 1, charts=False)
    before = kept.event.use_case if isinstance(kept.event, RunBegun) else event.use_case
    if before != event.use_case:
        raise OrderError(
            f"product {event.serial} was begun by use case {before}, asked for {event.use_case}: "
            f"continue it by {before}, or wire the next product of the order (remodel run --again)"
        )


def _store_snapshot(connection: Connection, run: int, count: int, state: RunState) -> None:
    """Replace the snapshot of a run."""
    values = {"run": run, "events": count, "data": packed_json(snapshot_of(state))}
    connection.execute(_STORE_SNAPSHOT, values)


def _refusal(
    connection: Connection, run: int, owner: int, events: int | None = None
) -> PlannerError:
    """Return why nothing can be added to a run of which so many events are known."""
    row = connection.execute(_RUN, {"run": run}).first()
    if row is None:
        return record_lost(f"no longer has run {run}")
    require_owner(connection, row.cell, owner)
    if row.ended:
        return OwnerError(f"run {run} has ended: nothing can be added to it")
    if row.owner == owner and events is not None:
        return record_lost(f"has {row.events} events of run {run}; its supervisor knows {events}")
    return OwnerError(
        f"run {run} belongs to another owner of cell {row.cell} (token {row.owner}; this one has "
        f"{owner}): take it up first"
    )
