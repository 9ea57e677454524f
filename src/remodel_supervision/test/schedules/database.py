"""A production database in memory: made once, copied for each schedule, and able to fail."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from sqlalchemy.engine import Connection

from remodel_production.core.production import Order
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import LostError
from schedules.process import Process
from schedules.simulation import Simulation

# [days] Julian date of 1970, and [s] of a day.
_EPOCH_D = 2440587.5
_DAY_S = 86400.0

# [s] since 1970 at which each schedule begins.
_BEGIN_S = 1.6e9


class Memory:
    """The database itself, whose clock is that of the simulation.

    Attributes:
        outage_until_s: [s] until when it does not answer.
        lost_answers: how many of the next commits are done without that anybody hears of it.
    """

    def __init__(self, order: Order) -> None:
        self.door = ProductionDatabase("sqlite://")
        self.door.add_order(order)
        with self.door._engine.connect() as connection:
            self._raw: Any = connection.connection.dbapi_connection
        self._content = self._raw.serialize()
        self.outage_until_s = 0.0
        self.lost_answers = 0

    def restore(self, simulation: Simulation) -> None:
        """Begin a schedule: the content is as it was made, and time is the simulation's."""
        self.outage_until_s, self.lost_answers = 0.0, 0
        self._raw.deserialize(self._content)
        self._raw.execute("PRAGMA foreign_keys=ON")
        self._raw.create_function(
            "julianday", 1, lambda _: _EPOCH_D + (_BEGIN_S + simulation.now_s) / _DAY_S
        )


class FailingDatabase(ProductionDatabase):
    """The door to it of one process, at which the process may die, and answers may get lost."""

    def __init__(self, memory: Memory, process: Process) -> None:
        """Open the door; nothing is connected or upgraded."""
        self._engine = memory.door._engine
        self._memory = memory
        self._process = process

    @contextmanager
    def transaction(self) -> Iterator[Connection]:
        """Give a connection; LostError before or after its commit."""
        self._process.step()
        self._require_answer()
        with super().transaction() as connection:
            yield connection
        self._process.step()
        if self._memory.lost_answers > 0:
            self._memory.lost_answers -= 1
            self._process.simulation.note(self._process.name, "the answer to a commit is lost")
            raise LostError("the production database does not answer: the connection broke")

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Give a connection that changes nothing; LostError if there is no answer."""
        self._process.step()
        self._require_answer()
        with super().reading() as connection:
            yield connection

    def _require_answer(self) -> None:
        if self._process.simulation.now_s < self._memory.outage_until_s:
            raise LostError("the production database does not answer: connection refused")
