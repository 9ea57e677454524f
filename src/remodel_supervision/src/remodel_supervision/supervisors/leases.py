"""The leases on tasks: which ones this cell has, and the renewal of the one under way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from remodel_production.errors import LostError
from remodel_supervision.core.runs.events import AsLeft, TaskElsewhere, TaskReturned
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.edge.task_leases import Holding
from remodel_supervision.supervisors.ports import EventLoop, Leases
from remodel_supervision.supervisors.run_record import RunRecord

# A cell's answer to a claim -> how the other cell has left the task.
_AS_LEFT = {
    Holding.ELSEWHERE: AsLeft.RUNNING,
    Holding.DONE: AsLeft.DONE,
    Holding.SET_ASIDE: AsLeft.SET_ASIDE,
}


class LeaseKeeper:
    """Claims tasks, records what other cells have, and renews the lease of one task at a time.

    Attributes:
        lost: why the task that is held is not this cell's any more; empty if it is.
        is_taken_over: whether another cell has taken it over.
    """

    def __init__(
        self,
        loop: EventLoop,
        leases: Leases,
        record: RunRecord,
        on_change: Callable[[], None],
    ) -> None:
        """Begin without any task.

        Args:
            loop: time, and what arrives.
            leases: of this cell.
            record: of the run.
            on_change: called when `lost` has changed.
        """
        self.lost = ""
        self.is_taken_over = False
        self._loop = loop
        self._leases = leases
        self._record = record
        self._on_change = on_change
        self._task = ""
        self._valid_until_s = 0.0

    def claim(self, name: str) -> bool:
        """Claim a task, and return whether this cell has it.

        If another cell has it, or has had it before, that is recorded.
        """
        state = self._record.state
        task = state.tasks[name]
        if name == state.current:
            if self._record.insist(lambda: self._leases.renew(name)):
                return True
            self._record.append(TaskElsewhere(name, "", AsLeft.RUNNING))
            return False
        claim = self._record.insist(lambda: self._leases.claim(name))
        if claim.holding is Holding.MINE:
            return True
        if claim.holding is Holding.MINE_UNVERIFIED:
            is_known = task.stage is Stage.UNVERIFIED or (
                task.attempts > 0 and claim.cell == state.cell
            )
            if not is_known:
                self._record.append(TaskReturned(name, claim.cell))
            return is_known
        self._record.append(TaskElsewhere(name, claim.cell, _AS_LEFT[claim.holding]))
        return False

    def give_back(self, name: str) -> None:
        """Give back a task that was claimed just now, unless it was begun before."""
        state = self._record.state
        if name != state.current and not state.tasks[name].attempts:
            self._record.insist(lambda: self._leases.give_back(name))

    def check_others(self) -> None:
        """Record which tasks other cells have ended, or have left to this one."""
        for name in self._record.state.in_stage(Stage.ELSEWHERE):
            claim = self._record.insist(lambda n=name: self._leases.claim(n))  # type: ignore[misc]
            if claim.holding in (Holding.DONE, Holding.SET_ASIDE):
                self._record.append(TaskElsewhere(name, claim.cell, _AS_LEFT[claim.holding]))
            elif claim.holding is not Holding.ELSEWHERE:
                self._record.append(TaskReturned(name, claim.cell))

    @contextmanager
    def held(self, task: str) -> Iterator[None]:
        """Renew the lease of a task, which was claimed just now, until the block is left."""
        self._task = task
        self._valid_until_s = self._loop.wall_s() + self._leases.lease_s
        timer = self._loop.every(self._leases.lease_s / 3, self._renew)
        try:
            yield
        finally:
            timer.cancel()
            self._task, self.lost, self.is_taken_over = "", "", False

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
            self.lost, self.is_taken_over = f"another cell has taken over task {self._task}", True
            self._on_change()
