"""Which supervisor owns a cell: one at a time, for as long as it renews its lease.

Each acquisition gets the next token. Whoever acts for the cell carries its token: the run log, the
task leases, the cell's services and its ability servers refuse an older one. Times are those of the
database's clock.
"""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import select, text, update
from sqlalchemy.orm import Session

from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.production_models import CellRow
from remodel_planner.errors import OwnerError

_CLOCK = {
    "sqlite": "SELECT (julianday('now') - 2440587.5) * 86400.0",
    "postgresql": "SELECT EXTRACT(EPOCH FROM clock_timestamp())",
}

# A cell that is not known begins above the tokens that were given before a backup was restored.
_FLOOR = "SELECT coalesce(max(token), 0) AS floor FROM cells WHERE name = '(restored)'"


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
        with self._database.transaction() as session:
            # Two stations may come first at once.
            session.execute(
                text(
                    "INSERT INTO cells (name, token, station, holder) SELECT :name, floor, '', '' "
                    f"FROM ({_FLOOR}) AS known WHERE true ON CONFLICT (name) DO NOTHING"
                ),
                {"name": self._cell},
            )
            row = session.scalars(
                select(CellRow).where(CellRow.name == self._cell).with_for_update()
            ).one()
            now = database_time_s(session)
            left_s = (row.lease_until or 0.0) - now
            if row.station != self._station and left_s > 0.0:
                return Refused(row.holder, left_s)
            row.token += 1
            row.station, row.holder = self._station, self._holder
            row.lease_until = now + self.lease_s
            return Owned(row.token)

    def renew(self, token: int) -> bool:
        """Keep the cell for another lease; False if it was released or has another owner now.

        Args:
            token: of the ownership.
        """
        with self._database.transaction() as session:
            until = database_time_s(session) + self.lease_s
            renewed = session.execute(
                update(CellRow)
                .where(
                    CellRow.name == self._cell,
                    CellRow.token == token,
                    CellRow.lease_until.is_not(None),
                )
                .values(lease_until=until)
            )
            return bool(renewed.rowcount)

    def release(self, token: int) -> None:
        """End the lease now; nothing happens if the cell has another owner.

        Args:
            token: of the ownership.
        """
        with self._database.transaction() as session:
            session.execute(
                update(CellRow)
                .where(CellRow.name == self._cell, CellRow.token == token)
                .values(lease_until=None)
            )


def live_owners(database: ProductionDatabase) -> tuple[LiveOwner, ...]:
    """Return the owners of cells whose leases have not run out, by cell."""
    with database.reading() as session:
        now = database_time_s(session)
        rows = session.scalars(
            select(CellRow).where(CellRow.lease_until > now).order_by(CellRow.name)
        )
        return tuple(LiveOwner(row.name, row.holder, row.lease_until - now) for row in rows)


def require_owner(session: Session, cell: str, token: int, *, lock: bool = False) -> None:
    """Raise OwnerError unless a token is the newest of its cell.

    Args:
        session: that asks.
        cell: name of the cell.
        token: of the ownership.
        lock: nobody else acquires the cell before the session's transaction has ended.
    """
    asked = select(CellRow).where(CellRow.name == cell)
    row = session.scalar(asked.with_for_update() if lock else asked)
    if row is None:
        raise OwnerError(f"nobody owns cell {cell}: acquire it first")
    if row.token != token:
        raise OwnerError(
            f"cell {cell} is owned by another supervisor now: {row.holder} (token {row.token}; "
            f"this one has {token})"
        )


def database_time_s(session: Session) -> float:
    """Return the time of the database's clock, [s] since 1970."""
    return float(session.scalar(text(_CLOCK[session.get_bind().dialect.name])))
