"""The lease of the task under way, kept as long as it is worked on."""

from __future__ import annotations

from collections.abc import Callable

from remodel_production.errors import LostError
from remodel_supervision.supervisors.ports import EventLoop, Leases, Timer


class LeaseKeeper:
    """Renews the lease of one task at a time.

    Attributes:
        lost: why the task is not this cell's any more; empty if it is.
        is_taken: whether another cell has taken it over.
    """

    def __init__(self, loop: EventLoop, leases: Leases, on_change: Callable[[], None]) -> None:
        """Take the leases; on_change is called when `lost` has changed."""
        self.lost = ""
        self.is_taken = False
        self._loop = loop
        self._leases = leases
        self._on_change = on_change
        self._task = ""
        self._valid_until_s = 0.0
        self._timer: Timer | None = None

    def hold(self, task: str) -> None:
        """Renew the lease of a task from now on; it was claimed or renewed just now."""
        self.release()
        self._task = task
        self._valid_until_s = self._loop.wall_s() + self._leases.lease_s
        self._timer = self._loop.every(self._leases.lease_s / 3, self._renew)

    def release(self) -> None:
        """Renew nothing any more."""
        if self._timer is not None:
            self._timer.cancel()
        self._timer, self._task = None, ""
        self.lost, self.is_taken = "", False

    def check(self) -> None:
        """Note a lease that has run out because it could not be renewed."""
        if self._task and not self.lost and self._loop.wall_s() > self._valid_until_s:
            self.lost = f"the lease of task {self._task} ran out: the database does not answer"
            self._on_change()

    def _renew(self) -> None:
        asked_s = self._loop.wall_s()
        try:
            has_it = self._leases.renew(self._task)
        except LostError:
            self.check()
            return
        if has_it and not self.lost:
            self._valid_until_s = asked_s + self._leases.lease_s
        elif not has_it:
            self.lost, self.is_taken = f"another cell has taken over task {self._task}", True
            self._on_change()
