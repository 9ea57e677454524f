"""The production knowledge database: orders, what was done; its versions and its errors.

SQLite by default, PostgreSQL by URL. Every change is one transaction, so that nothing is stored by
half. docs/production-database.md describes and draws the tables.
"""

from __future__ import annotations

import json
import os
import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec
from sqlalchemy import and_, bindparam, create_engine, delete, event, insert, inspect, select, text
from sqlalchemy.engine import Connection, Engine, Row, make_url
from sqlalchemy.exc import (
    DBAPIError,
    DisconnectionError,
    InterfaceError,
    OperationalError,
    SQLAlchemyError,
)
from sqlalchemy.exc import TimeoutError as PoolTimeoutError
from sqlalchemy.pool import QueuePool

from remodel_production.core.production import Ability, AbilityParameter, Order
from remodel_production.edge.database.production_models import (
    AbilityParameterRow,
    AbilityRow,
    Base,
    ConstraintRow,
    OrderRow,
    PreferenceRow,
    RehearsalRow,
    TaskRow,
    WireRow,
)
from remodel_production.edge.database.production_rows import (
    add_order_rows,
    add_preference_rows,
    order_of_row,
    preferences_of_rows,
)
from remodel_production.errors import LostError, OrderError, RecordLostError, blamed
from remodel_run.rehearsal import Rehearsal
from remodel_states.edge.write_ahead import write_ahead

# Texts of OperationalError that waiting does not help against: SQLite's of a table or file that is
# missing, replaced or damaged, PostgreSQL's of a dropped database.
_GONE = (
    "no such table",
    "no such column",
    "malformed",
    "not a database",
    "disk I/O error",
    "readonly database",
    "does not exist",
)


@contextmanager
def reported() -> Iterator[None]:
    """Report what goes wrong inside in the planner's errors.

    Raises:
        LostError: if the database does not answer; it may answer later.
        RecordLostError: if tables, rows or the whole file are missing or damaged.
    """
    try:
        yield
    except PoolTimeoutError as error:
        raise LostError(f"the production database does not answer: {error}") from error
    except DBAPIError as error:
        line = str(error.orig).strip().splitlines()[0] if str(error.orig).strip() else str(error)
        if _may_come_back(error, line):
            raise LostError(f"the production database does not answer: {line}") from error
        raise record_lost(f"cannot be used: {line}") from error
    except (json.JSONDecodeError, UnicodeDecodeError, zlib.error) as error:
        raise record_lost(f"has a damaged entry: {error}") from error


def record_lost(what: str) -> RecordLostError:
    """Return the error about a production database that, for instance, "has no run 12"."""
    return RecordLostError(
        f"the production database {what}; restore a backup (remodel restore FILE)"
    )


def _may_come_back(error: DBAPIError, line: str) -> bool:
    silent = isinstance(error, OperationalError | InterfaceError) or error.connection_invalidated
    return silent and not any(text in line for text in _GONE)


NEWEST = "0008"
_VERSION_TABLE = "alembic_version"
MIGRATIONS = Path(__file__).parent / "migrations"
# Any number that no other program takes a lock by, in one database.
_LOCK = 5_151_002


def version_of(connection: Connection) -> str | None:
    """Return the database's version; None if it has none."""
    if not inspect(connection).has_table(_VERSION_TABLE):
        return None
    version = connection.scalar(text(f"SELECT version_num FROM {_VERSION_TABLE}"))
    return None if version is None else str(version)


def upgrade(connection: Connection) -> None:
    """Bring a database to the newest version: an empty one, or of any version that is known.

    Args:
        connection: with a transaction that the migrations become part of.

    Raises:
        OrderError: if the database is of a version that this program does not know.
    """
    if connection.dialect.name == "postgresql":
        # One program at a time; the lock is given back at the transaction's end.
        connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _LOCK})
    version = version_of(connection)
    if version == NEWEST:
        return
    # Alembic takes longer to load than a database to open, and is needed once in its life.
    from alembic import command
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.attributes["connection"] = connection
    if version is None:
        Base.metadata.create_all(connection, checkfirst=False)
        command.stamp(config, "head")
        return
    known = {script.revision for script in ScriptDirectory.from_config(config).walk_revisions()}
    if version not in known:
        raise OrderError(
            f"is of version {version}; this program knows versions {', '.join(sorted(known))}: "
            "use the program that made it, or give another database (--database)"
        )
    command.upgrade(config, "head")


# [s] that a program waits for another one's transaction; an import takes one second.
WAIT_S = 30

_ORDER = select(OrderRow).where(OrderRow.name == bindparam("order"))
_LOCKED_ORDER = _ORDER.with_for_update()

# Tasks of orders, to be narrowed down by the order and the wire; indexes find them.
TASKS = (
    select(TaskRow)
    .join(OrderRow, TaskRow.order_id == OrderRow.id)
    .join(WireRow, and_(TaskRow.wire_id == WireRow.id, WireRow.product_id == OrderRow.product_id))
)


class ProductionDatabase:
    """The database's door: values in, values out."""

    def __init__(self, url: str) -> None:
        """Connect, and bring the database to this program's version.

        Raises:
            OrderError: if there is no database at the URL, or a newer program has made it.
        """
        with blamed(f"database {_shown(url)}"):
            try:
                self._engine = _engine(url)
                with self._begun("DEFERRED") as connection:
                    is_newest = version_of(connection) == NEWEST
                if not is_newest:
                    with self._begun("IMMEDIATE") as connection:
                        upgrade(connection)
            except (SQLAlchemyError, ImportError) as error:
                raise OrderError(str(error).splitlines()[0]) from error

    def close(self) -> None:
        """Close the connections to the database."""
        self._engine.dispose()

    def add_order(
        self, order: Order, preferences: object = None, abilities: Sequence[Ability] = ()
    ) -> None:
        """Store an order, whole or not at all.

        Args:
            order: to store.
            preferences: parsed document of the user's preferences of its plan; None for none.
            abilities: of the cell; those that are known already are brought up to date.

        Raises:
            OrderError: if there is an order of that name already.
        """
        with self.transaction() as connection:
            if connection.execute(_ORDER, {"order": order.name}).first() is not None:
                raise OrderError(
                    f"the database has an order {order.name} already: give another name (--order)"
                )
            number = add_order_rows(connection, order)
            add_preference_rows(connection, number, preferences)
            _set_abilities(connection, abilities)

    def order(self, name: str) -> Order:
        """Return an order; OrderError if there is none of that name."""
        with self.reading() as connection:
            return order_of_row(connection, order_row(connection, name))

    def order_names(self) -> tuple[str, ...]:
        """Return the names of all orders, in the order in which they were stored."""
        with self.reading() as connection:
            return _order_names(connection)

    def preferences(self, name: str) -> object:
        """Return the document of an order's preferences, None if it has none.

        Raises:
            OrderError: if there is no order of that name.
        """
        with self.reading() as connection:
            return preferences_of_rows(connection, order_row(connection, name).id)

    def set_preferences(self, name: str, document: object) -> None:
        """Store an order's preferences, parsed, in place of those that it has; None for none.

        Raises:
            OrderError: if there is no order of that name, or the document has no sections.
        """
        with self.transaction() as connection:
            number = order_row(connection, name).id
            for table in (PreferenceRow, ConstraintRow):
                connection.execute(delete(table).where(table.order_id == number))
            add_preference_rows(connection, number, document)

    def abilities(self) -> tuple[Ability, ...]:
        """Return the abilities that are known, by name."""
        with self.reading() as connection:
            rows = connection.execute(select(AbilityRow).order_by(AbilityRow.name)).all()
            return tuple(_ability(connection, row) for row in rows)

    @contextmanager
    def transaction(self) -> Iterator[Connection]:
        """Give a connection whose changes are stored together, or not at all.

        Raises:
            LostError: if the database does not answer.
            RecordLostError: if it is damaged, or lacks tables.
        """
        with reported(), self._begun("IMMEDIATE") as connection:
            yield connection

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Give a connection that changes nothing; raises what `transaction` raises."""
        with reported(), self._begun("DEFERRED") as connection:
            yield connection

    @contextmanager
    def _begun(self, kind: str) -> Iterator[Connection]:
        """Give a connection with a transaction, of a kind that SQLite has.

        Those that change something are IMMEDIATE: they wait for each other from their start.
        """
        with self._engine.begin() as connection:
            if connection.dialect.name == "sqlite":
                connection.exec_driver_sql(f"BEGIN {kind}")
            yield connection


def _engine(url: str) -> Engine:
    made = make_url(url)
    is_sqlite = made.get_backend_name() == "sqlite"
    is_file = is_sqlite and made.database not in (None, "", ":memory:")
    # Connections are kept: SQLite copies its log into the file when the last one is closed.
    pool = {"poolclass": QueuePool, "connect_args": {"check_same_thread": False}}
    engine = create_engine(url, future=True, json_serializer=_compact, **(pool if is_file else {}))
    if is_sqlite:
        event.listen(engine, "connect", _prepare_sqlite)
    if is_file:
        _watch_file(engine)
    return engine


def _compact(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False)


def _watch_file(engine: Engine) -> None:
    """Report a database file that is gone or emptied, and open one that was put in its place.

    SQLite would begin an empty one, or go on with what it remembers of the one that is gone.
    """
    file = engine.url.database or ""
    opened = False

    def before_connect(*_: object) -> None:
        if opened:
            _identity(file)

    def on_connect(_connection: object, record: Any) -> None:  # noqa: ANN401 - the pool's
        nonlocal opened
        opened = True
        record.info["file"] = _identity(file)

    def on_checkout(_connection: object, record: Any, _proxy: object) -> None:  # noqa: ANN401 - likewise
        if record.info["file"] != _identity(file):
            raise DisconnectionError

    event.listen(engine, "do_connect", before_connect)
    event.listen(engine, "connect", on_connect)
    event.listen(engine, "checkout", on_checkout)


def _identity(file: str) -> tuple[int, int]:
    """Return what identifies a database file; RecordLostError if there is none of that name.

    It is not opened: closing it would release the locks that SQLite has on it in this process.
    """
    try:
        status = os.stat(file)
    except FileNotFoundError:
        raise record_lost(f"{file} is gone") from None
    if not status.st_size:
        raise record_lost(f"{file} is empty")
    return status.st_dev, status.st_ino


def _prepare_sqlite(connection: sqlite3.Connection, _record: object) -> None:
    """Set what SQLite forgets with each connection; the driver is not to begin transactions."""
    connection.isolation_level = None
    for setting in ("foreign_keys=ON", f"busy_timeout={WAIT_S * 1000}"):
        connection.execute(f"PRAGMA {setting}")
    write_ahead(connection, WAIT_S)


def _shown(url: str) -> str:
    """Return a URL without its password."""
    head, at, tail = url.rpartition("@")
    return f"{head.rpartition(':')[0]}:***@{tail}" if at and ":" in head.split("//")[-1] else url


def order_row(connection: Connection, name: str, *, lock: bool = False) -> Row:
    """Return an order's row, locked on request; OrderError if there is none of that name."""
    asked = _LOCKED_ORDER if lock else _ORDER
    row = connection.execute(asked, {"order": name}).first()
    if row is None:
        known = ", ".join(_order_names(connection)) or "none"
        raise OrderError(f"the database has no order {name}; it has: {known}")
    return row


def _order_names(connection: Connection) -> tuple[str, ...]:
    return tuple(connection.scalars(select(OrderRow.name).order_by(OrderRow.id)))


def _set_abilities(connection: Connection, abilities: Sequence[Ability]) -> None:
    rows = {row.name: row for row in connection.execute(select(AbilityRow))}
    for ability in abilities:
        row = rows.get(ability.name)
        if row is not None and _ability(connection, row) == ability:
            continue
        if row is not None:
            connection.execute(delete(AbilityRow).where(AbilityRow.id == row.id))
        values = {"name": ability.name, "description": ability.description}
        (number,) = connection.execute(insert(AbilityRow), values).inserted_primary_key
        parameters = [
            {"ability_id": number, "position": position, **asdict(parameter)}
            for position, parameter in enumerate(ability.parameters)
        ]
        if parameters:
            connection.execute(insert(AbilityParameterRow), parameters)


def _ability(connection: Connection, row: Row) -> Ability:
    rows = connection.execute(
        select(AbilityParameterRow)
        .where(AbilityParameterRow.ability_id == row.id)
        .order_by(AbilityParameterRow.position)
    )
    parameters = tuple(AbilityParameter(p.name, p.type, p.description) for p in rows)
    return Ability(row.name, row.description, parameters)


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
