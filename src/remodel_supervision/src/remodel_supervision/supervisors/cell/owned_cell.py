"""The ownership of a cell: acquired before anything is supervised, and renewed from then on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.errors import LostError, PlannerError, RecordLostError
from remodel_supervision.supervisors.ports import EventLoop

# [s] wall time between two attempts to own the cell.
ACQUIRE_EVERY_S = 1.0


class OwnedCell:
    """Owns a cell, for as long as its lease is renewed.

    Attributes:
        name: of the cell.
        token: of the ownership; 0 while there is none.
        taken_over: why the cell has another owner now; empty if that is not known.
    """

    def __init__(self, name: str, ownership: CellOwnership, loop: EventLoop) -> None:
        """Take the lease, which is renewed once the cell is acquired.

        Args:
            name: of the cell.
            ownership: of the cell.
            loop: time, and what arrives.
        """
        self.name = name
        self.token = 0
        self.taken_over = ""
        self._ownership = ownership
        self._loop = loop
        self._until_s = 0.0
        loop.every(ownership.lease_s / 3, self._renew)

    def acquire(self, on_wait: Callable[[str], None]) -> None:
        """Acquire the cell, however long that takes.

        Args:
            on_wait: called with the reason after each attempt that failed.
        """
        while True:
            asked_s = self._loop.wall_s()
            try:
                found = self._ownership.acquire()
                if isinstance(found, Owned):
                    break
                on_wait(
                    f"cell {self.name} is owned by another station: {found.holder}; stop that one, "
                    "or give this cell a name of its own (cell_name:=)"
                )
            except (LostError, RecordLostError) as error:
                on_wait(str(error))
            self._loop.run_until(lambda: False, ACQUIRE_EVERY_S)
        self.token = found.token
        self.taken_over = ""
        self._until_s = asked_s + self._ownership.lease_s

    def disowned(self) -> str:
        """Return why the cell is not owned, as far as is known; empty if it is."""
        if not self.taken_over and self._loop.wall_s() > self._until_s:
            return (
                f"the ownership of cell {self.name} could not be renewed: the production database "
                "does not answer"
            )
        return self.taken_over

    def give_up(self) -> None:
        """Renew the lease no more."""
        self.token = 0

    def release(self) -> None:
        """End the lease, so that another station can acquire the cell at once."""
        with contextlib.suppress(PlannerError):
            if self.token:
                self._ownership.release(self.token)

    def _renew(self) -> None:
        if not self.token:
            return
        asked_s = self._loop.wall_s()
        with contextlib.suppress(LostError):
            if not self._ownership.renew(self.token):
                self.taken_over = f"another supervisor owns cell {self.name} now"
                return
            self._until_s = asked_s + self._ownership.lease_s
