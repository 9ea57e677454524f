"""Leases on tasks, so that several cells work on one order without doing anything twice.

A cell takes a task by a lease that it renews while it works; when a cell dies, its leases run out,
and another cell takes its tasks over. It waits for another third of a lease before it does, so that
a cell that could not renew has time to stop what it runs. Times are those of the database's clock.
Rows are locked while they are checked (SELECT ... FOR UPDATE; SQLite lets one writer in at a time).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from sqlalchemy import bindparam, select, update
from sqlalchemy.engine import Connection, Row

from remodel_production.edge.database.cell_ownership import database_time_s, require_owner
from remodel_production.edge.database.production_database import (
    TASKS,
    ProductionDatabase,
    order_row,
)
from remodel_production.edge.database.production_models import CellRow, OrderRow, TaskRow, WireRow
from remodel_production.errors import OrderError

_TASK = TASKS.where(
    OrderRow.name == bindparam("order"), WireRow.name == bindparam("task")
).with_for_update(of=TaskRow)
_CHANGE = update(TaskRow).where(TaskRow.id == bindparam("number"))
_IS_OWNER = select(CellRow.name).where(
    CellRow.name == bindparam("cell"), CellRow.token == bindparam("owner")
)
_BEGUN_ELSEWHERE = (
    select(TaskRow.id)
    .join(OrderRow, TaskRow.order_id == OrderRow.id)
    .where(
        OrderRow.name == bindparam("order"),
        TaskRow.state != "open",
        TaskRow.cell.not_in(("", bindparam("mine"))),
    )
    .limit(1)
)


class Holding(Enum):
    """What a cell learns when it asks for a task.

    MINE: it has it, and no cell has begun it before. MINE_UNVERIFIED: it has it, and a cell has
    begun it before. ELSEWHERE: another cell has it. DONE, SET_ASIDE: it is, by some cell.
    """

    MINE = "mine"
    MINE_UNVERIFIED = "mine, unverified"
    ELSEWHERE = "elsewhere"
    DONE = "done"
    SET_ASIDE = "set aside"


@dataclass(frozen=True)
class Claim:
    """The answer to a cell that asks for a task.

    Attributes:
        cell: that has it, or has had it last; empty if none.
    """

    holding: Holding
    cell: str


class TaskLeases:
    """One cell's leases on the tasks of one order."""

    def __init__(
        self, database: ProductionDatabase, order: str, cell: str, lease_s: float, token: int
    ) -> None:
        """Take leases for a cell.

        Args:
            database: that keeps them.
            order: name of the order.
            cell: name of the cell.
            lease_s: [s] wall time for which a task is taken or renewed; the same for all cells of
                an order.
            token: of the ownership of the cell.
        """
        self._database = database
        self._order = order
        self._cell = cell
        self._token = token
        self.lease_s = lease_s

    def claim(self, task: str) -> Claim:
        """Take a task unless another cell has it, or it is done.

        Raises:
            OrderError: if the order has no such task.
            OwnerError: if another supervisor owns the cell now.
        """
        with self._database.transaction() as connection:
            require_owner(connection, self._cell, self._token)
            row = self._locked(connection, task)
            now = database_time_s(connection)
            if row.state in (Holding.DONE.value, Holding.SET_ASIDE.value):
                return Claim(Holding(row.state), row.cell)
            is_live = row.lease_until is not None and row.lease_until + self.lease_s / 3 > now
            if row.cell != self._cell and is_live:
                return Claim(Holding.ELSEWHERE, row.cell)
            taken = {
                "state": "begun",
                "cell": self._cell,
                "token": self._token,
                "lease_until": now + self.lease_s,
            }
            connection.execute(_CHANGE, {"number": row.id, **taken})
            is_begun = row.state == "begun"
            return Claim(Holding.MINE_UNVERIFIED if is_begun else Holding.MINE, row.cell)

    def begun_elsewhere(self) -> bool:
        """Return whether another cell has begun, done or skipped a task of the order."""
        with self._database.reading() as connection:
            asked = {"order": self._order, "mine": self._cell}
            return connection.execute(_BEGUN_ELSEWHERE, asked).first() is not None

    def renew(self, task: str) -> bool:
        """Keep a task for another lease; False if another cell or supervisor has taken it over."""
        with self._database.transaction() as connection:
            row = self._locked(connection, task)
            if not self._is_mine(connection, row):
                return False
            until = database_time_s(connection) + self.lease_s
            kept = {"token": self._token, "lease_until": until}
            connection.execute(_CHANGE, {"number": row.id, **kept})
            return True

    def give_back(self, task: str) -> None:
        """Let other cells have a task that was not done; it counts as one never begun."""
        with self._database.transaction() as connection:
            row = self._locked(connection, task)
            if self._is_mine(connection, row):
                open_again = {"state": "open", "cell": "", "token": 0, "lease_until": None}
                connection.execute(_CHANGE, {"number": row.id, **open_again})

    def _is_mine(self, connection: Connection, row: Row) -> bool:
        """Return whether the cell has begun the task, and this supervisor owns the cell."""
        if row.cell != self._cell or row.state != "begun":
            return False
        asked = {"cell": self._cell, "owner": self._token}
        return connection.execute(_IS_OWNER, asked).first() is not None

    def _locked(self, connection: Connection, task: str) -> Row:
        """Return the row of a task, locked until the transaction has ended."""
        row = connection.execute(_TASK, {"order": self._order, "task": task}).first()
        if row is None:
            order_row(connection, self._order)
            raise OrderError(f"order {self._order} has no task {task}")
        return row
