"""Events to rows and back: charts are stored once, beside the events that name them."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

from sqlalchemy import bindparam, insert, select, text
from sqlalchemy.engine import Connection

from remodel_production.edge.database.database_errors import record_lost
from remodel_production.edge.database.packed import packed
from remodel_production.edge.database.production_models import ChartRow, RunEventRow
from remodel_supervision.core.runs.event_form import data_of, event_from, kind_of
from remodel_supervision.core.runs.events import Event, TaskBegun

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
