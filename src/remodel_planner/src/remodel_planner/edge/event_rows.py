"""Events to rows and back: charts are stored once, beside the events that name them."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

from sqlalchemy import insert, select, text
from sqlalchemy.orm import Session

from remodel_planner.core.supervision.event_form import data_of, event_from, kind_of
from remodel_planner.core.supervision.events import Event, TaskBegun
from remodel_planner.edge.database_errors import record_lost
from remodel_planner.edge.packed import packed
from remodel_planner.edge.production_models import ChartRow, RunEventRow

_CHART, _HASH = "chart", "chart_hash"
_ADD = insert(RunEventRow.__table__)


@dataclass(frozen=True)
class KeptEvent:
    """An event as it was kept.

    Attributes:
        at: wall time, UTC.
    """

    at: datetime
    event: Event


def add_event(session: Session, run: int, position: int, event: Event) -> None:
    """Add an event to a run.

    Args:
        session: with a transaction.
        run: number of the run.
        position: of the event in the run, from 0.
        event: that happened.
    """
    data = data_of(event)
    if isinstance(event, TaskBegun):
        del data[_CHART]
        data[_HASH] = _stored_chart(session, event.chart)
    row = {"run_id": run, "position": position, "at": now(), "kind": kind_of(event), "data": data}
    session.connection().execute(_ADD, row)


def events_between(
    session: Session, run: int, first: int, end: int, *, charts: bool
) -> Iterator[KeptEvent]:
    """Yield the events of a run at some positions.

    Args:
        session: to read with.
        run: number of the run.
        first: position of the first event.
        end: position after the last event.
        charts: whether the charts are read; without, they are empty.

    Raises:
        RecordLostError: if an event or a chart is missing.
    """
    rows = session.execute(
        select(RunEventRow.at, RunEventRow.kind, RunEventRow.data)
        .where(RunEventRow.run_id == run, RunEventRow.position >= first, RunEventRow.position < end)
        .order_by(RunEventRow.position)
    ).all()
    if len(rows) != end - first:
        raise record_lost(
            f"has {len(rows)} of the {end - first} events of run {run} from number {first} on"
        )
    hashes = {row.data[_HASH] for row in rows if _HASH in row.data}
    xml_of = _charts(session, hashes) if charts else dict.fromkeys(hashes, "")
    for at, kind, data in rows:
        if _HASH in data:
            data[_CHART] = xml_of[data.pop(_HASH)]
        yield KeptEvent(at, event_from(kind, data))


def now() -> datetime:
    """Return the wall time, UTC, as it is stored."""
    return datetime.now(UTC).replace(tzinfo=None)


def _stored_chart(session: Session, xml: str) -> str:
    """Store a chart unless it is there, and return its hash."""
    digest = hashlib.sha256(xml.encode()).hexdigest()
    if session.scalar(select(ChartRow.hash).where(ChartRow.hash == digest)) is None:
        # Another cell may store it at the same moment.
        session.execute(
            text(
                "INSERT INTO charts (hash, xml) VALUES (:hash, :xml) ON CONFLICT (hash) DO NOTHING"
            ),
            {"hash": digest, "xml": packed(xml)},
        )
    return digest


def _charts(session: Session, hashes: Collection[str]) -> dict[str, str]:
    found = select(ChartRow.hash, ChartRow.xml).where(ChartRow.hash.in_(hashes))
    xml_of = {digest: xml for digest, xml in session.execute(found)} if hashes else {}
    missing = set(hashes) - xml_of.keys()
    if missing:
        raise record_lost(f"has no chart {min(missing)}")
    return xml_of
