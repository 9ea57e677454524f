"""Which supervisor owns a cell: one at a time, for as long as it renews its lease.

Each acquisition gets the next token. A program that acts for the cell carries its token: the run
log, the task leases, the cell's services and its ability servers refuse an older one. Times are
those of the database's clock.
"""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import bindparam, select, text, update
from sqlalchemy.engine import Connection

from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.database.production_models import CellRow
from remodel_production.errors import OwnerError

_CLOCK = {
    "sqlite": text("SELECT (julianday('now') - 2440587.5) * 86400.0"),
    "postgresql": text("SELECT EXTRACT(EPOCH FROM clock_timestamp())"),
}

# A cell that is not known begins above the tokens that were given before a backup was restored. Two
# stations may come first at once.
_ADD_CELL = text(
    "INSERT INTO cells (name, token, station, holder) SELECT :cell, floor, '', '' FROM "
    "(SELECT coalesce(max(token), 0) AS floor FROM cells WHERE name = '(restored)') AS known "
    "WHERE true ON CONFLICT (name) DO NOTHING"
)

_CELL = select(CellRow).where(CellRow.name == bindparam("cell"))
_LOCKED_CELL = _CELL.with_for_update()
_TAKE = update(CellRow).where(CellRow.name == bindparam("cell"))
_RENEW = (
    update(CellRow)
    .where(
        CellRow.name == bindparam("cell"),
        CellRow.token == bindparam("owner"),
        CellRow.lease_until.is_not(None),
    )
    .values(lease_until=bindparam("until"))
)
_RELEASE = (
    update(CellRow)
    .where(CellRow.name == bindparam("cell"), CellRow.token == bindparam("owner"))
    .values(lease_until=None)
)


@dataclass(frozen=True)
class Owned:
    """The cell is this supervisor's.

    Attributes:
        token: larger than that of any owner before.
    """

    token: int


@dataclass(frozen=True)
class Refused:
    """Another station owns the cell.

    Attributes:
        holder: its host, process and ROS master, for persons.
        left_s: [s] until its lease runs out unless it renews it.
    """

    holder: str
    left_s: float


@dataclass(frozen=True)
class LiveOwner:
    """A supervisor whose lease on a cell has not run out."""

    cell: str
    holder: str
    left_s: float


class CellOwnership:
    """One supervisor's ownership of one cell."""

    def __init__(
        self, database: ProductionDatabase, cell: str, station: str, holder: str, lease_s: float
    ) -> None:
        """Prepare to own a cell.

        Args:
            database: that keeps who owns it.
            cell: name of the cell.
            station: identifies the station; a supervisor that is restarted there takes over from
                its predecessor at once.
            holder: host, process and ROS master of this supervisor, for persons.
            lease_s: [s] wall time for which the cell is owned or renewed.
        """
        self._database = database
        self._cell = cell
        self._station = station
        self._holder = holder
        self.lease_s = lease_s

    def acquire(self) -> Owned | Refused:
        """Take the cell, unless another station holds a live lease on it."""
        with self._database.transaction() as connection:
            connection.execute(_ADD_CELL, {"cell": self._cell})
            row = connection.execute(_LOCKED_CELL, {"cell": self._cell}).one()
            now = database_time_s(connection)
            left_s = (row.lease_until or 0.0) - now
            if row.station != self._station and left_s > 0.0:
                return Refused(row.holder, left_s)
            taken = {
                "cell": self._cell,
                "token": row.token + 1,
                "station": self._station,
                "holder": self._holder,
                "lease_until": now + self.lease_s,
            }
            connection.execute(_TAKE, taken)
            return Owned(row.token + 1)

    def renew(self, token: int) -> bool:
        """Keep the cell for another lease; False if it was released or has another owner now."""
        with self._database.transaction() as connection:
            until = database_time_s(connection) + self.lease_s
            asked = {"cell": self._cell, "owner": token, "until": until}
            return bool(connection.execute(_RENEW, asked).rowcount)

    def release(self, token: int) -> None:
        """End the lease now; nothing happens if the cell has another owner."""
        with self._database.transaction() as connection:
            connection.execute(_RELEASE, {"cell": self._cell, "owner": token})


def live_owners(database: ProductionDatabase) -> tuple[LiveOwner, ...]:
    """Return the owners of cells whose leases have not run out, by cell."""
    with database.reading() as connection:
        now = database_time_s(connection)
        rows = connection.execute(
            select(CellRow).where(CellRow.lease_until > now).order_by(CellRow.name)
        )
        return tuple(LiveOwner(row.name, row.holder, row.lease_until - now) for row in rows)


def require_owner(connection: Connection, cell: str, token: int, *, lock: bool = False) -> None:
    """Raise OwnerError unless a token is the newest of its cell.

    Args:
        connection: with a transaction.
        cell: name of the cell.
        token: of the ownership.
        lock: no other supervisor acquires the cell before the transaction has ended.
    """
    row = connection.execute(_LOCKED_CELL if lock else _CELL, {"cell": cell}).first()
    if row is None:
        raise OwnerError(f"no supervisor owns cell {cell}: acquire it first")
    if row.token != token:
        raise OwnerError(
            f"cell {cell} is owned by another supervisor now: {row.holder} (token {row.token}; "
            f"this one has {token})"
        )


def database_time_s(connection: Connection) -> float:
    """Return the time of the database's clock, [s] since 1970."""
    return float(connection.scalar(_CLOCK[connection.dialect.name]))
