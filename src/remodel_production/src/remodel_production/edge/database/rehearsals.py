"""The rehearsals of orders, as they are kept."""

from __future__ import annotations

from datetime import UTC, datetime

import msgspec
from sqlalchemy import insert, select
from sqlalchemy.engine import Connection

from remodel_production.edge.database.production_database import ProductionDatabase, order_row
from remodel_production.edge.database.production_models import RehearsalRow
from remodel_run.rehearsal import Rehearsal


def keep_rehearsal(database: ProductionDatabase, order: str, rehearsal: Rehearsal) -> None:
    """Keep a rehearsal of an order; OrderError if there is no such order."""
    with database.transaction() as connection:
        connection.execute(
            insert(RehearsalRow),
            {
                "order_id": order_row(connection, order).id,
                "made": datetime.now(UTC).replace(tzinfo=None),
                "data": msgspec.to_builtins(rehearsal),
            },
        )


def last_rehearsal(database: ProductionDatabase, order: str) -> Rehearsal | None:
    """Return the newest rehearsal of an order; None if there is none.

    Raises:
        OrderError: if there is no such order.
    """
    with database.reading() as connection:
        number = order_row(connection, order).id
        data = connection.scalar(
            select(RehearsalRow.data)
            .where(RehearsalRow.order_id == number)
            .order_by(RehearsalRow.id.desc())
            .limit(1)
        )
    return None if data is None else msgspec.convert(data, Rehearsal)


def rehearsals(connection: Connection) -> tuple[Rehearsal, ...]:
    """Return the newest rehearsal of each order."""
    rows = connection.execute(
        select(RehearsalRow.order_id, RehearsalRow.data).order_by(RehearsalRow.id)
    )
    newest = {order: data for order, data in rows}
    return tuple(msgspec.convert(data, Rehearsal) for data in newest.values())
