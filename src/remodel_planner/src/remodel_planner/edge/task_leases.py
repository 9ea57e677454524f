"""Leases on tasks, so that several cells work on one order without doing anything twice.

A cell takes a task by a lease that it renews while it works; when a cell dies, its leases run out,
and another cell takes its tasks over. It waits for another third of a lease before it does, so that
a cell that could not renew has time to stop what it runs. Times are those of the database's clock.
Rows are locked while they are checked (SELECT ... FOR UPDATE; SQLite lets one writer in at a time).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from sqlalchemy import select
from sqlalchemy.orm import Session

from remodel_planner.edge.cell_ownership import database_time_s, require_owner
from remodel_planner.edge.production_database import ProductionDatabase, order_row, task_row
from remodel_planner.edge.production_models import CellRow, TaskRow
from remodel_planner.errors import OrderError


class Holding(Enum):
    """What a cell learns when it asks for a task.

    MINE: it has it, and nobody has begun it before. MINE_IN_DOUBT: it has it, and a cell has begun
    it before. ELSEWHERE: another cell has it. DONE, SET_ASIDE: it is, by some cell.
    """

    MINE = "mine"
    MINE_IN_DOUBT = "mine in doubt"
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
        with self._database.transaction() as session:
            require_owner(session, self._cell, self._token)
            row = self._row(session, task)
            before, now = row.cell, database_time_s(session)
            if row.state in (Holding.DONE.value, Holding.SET_ASIDE.value):
                return Claim(Holding(row.state), before)
            is_live = row.lease_until is not None and row.lease_until + self.lease_s / 3 > now
            if before != self._cell and is_live:
                return Claim(Holding.ELSEWHERE, before)
            begun = row.state == "begun"
            row.state, row.cell, row.token = "begun", self._cell, self._token
            row.lease_until = now + self.lease_s
            return Claim(Holding.MINE_IN_DOUBT if begun else Holding.MINE, before)

    def begun_elsewhere(self) -> bool:
        """Return whether another cell has begun, done or set aside a task of the order."""
        with self._database.reading() as session:
            order = order_row(session, self._order)
            begun = select(TaskRow.id).where(
                TaskRow.order_id == order.id,
                TaskRow.state != "open",
                TaskRow.cell.not_in(("", self._cell)),
            )
            return session.scalar(begun.limit(1)) is not None

    def renew(self, task: str) -> bool:
        """Keep a task for another lease; False if another cell or supervisor has taken it over."""
        with self._database.transaction() as session:
            row = self._row(session, task)
            if not self._is_mine(session, row):
                return False
            row.token, row.lease_until = self._token, database_time_s(session) + self.lease_s
            return True

    def give_back(self, task: str) -> None:
        """Let other cells have a task that was not done; it counts as one never begun."""
        with self._database.transaction() as session:
            row = self._row(session, task)
            if self._is_mine(session, row):
                row.state, row.cell, row.token, row.lease_until = "open", "", 0, None

    def _is_mine(self, session: Session, row: TaskRow) -> bool:
        """Return whether the cell has begun the task, and this supervisor owns the cell."""
        token = session.scalar(select(CellRow.token).where(CellRow.name == self._cell))
        return token == self._token and row.cell == self._cell and row.state == "begun"

    def _row(self, session: Session, task: str) -> TaskRow:
        order = order_row(session, self._order)
        row = task_row(session, order.id, task, lock=True)
        if row is None:
            raise OrderError(f"order {self._order} has no task {task}")
        return row
