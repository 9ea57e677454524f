"""What a cell must hold while it moves: the leases on its tasks, an open gate, its connections.

The gate keeper closes and opens the gate, and has what the supervisor itself makes move pass it.
When something was lost or this process ends, what runs is stopped, and what was lost is waited
for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from remodel_production.errors import LostError
from remodel_supervision.core.runs.events import (
    AsLeft,
    Blocked,
    Interrupted,
    TaskElsewhere,
    TaskReturned,
)
from remodel_supervision.core.runs.gate import Circumstances, Gate, Permit, decide_halt, decide_hold
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.edge.task_leases import Holding
from remodel_supervision.errors import HaltedError
from remodel_supervision.supervisors.ports import EventLoop, Leases, Peers
from remodel_supervision.supervisors.run_record import RETRY_S, RunRecord
from remodel_supervision.supervisors.task_supervisor import TaskSupervisor

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


# What the use case supervisor itself makes move passes the gate under this name.
SUPERVISOR = "supervisor"

# [s] wall time between two checks whether a gate that holds is open.
_CHECK_S = 0.2


class GateKeeper:
    """Closes and opens the gate of one run.

    Attributes:
        gate: that everything passes that moves.
        tasks: runs behaviors, whose operations pass the gate.
    """

    def __init__(
        self,
        gate: Gate,
        record: RunRecord,
        loop: EventLoop,
        tasks: TaskSupervisor,
        leases: LeaseKeeper,
        disowned: Callable[[], str],
    ) -> None:
        """Take the gate; the time of the run counts from now on.

        Args:
            gate: that everything passes that moves.
            record: of the run.
            loop: time, and what arrives.
            tasks: runs behaviors, whose operations pass the gate.
            leases: on the tasks.
            disowned: returns why this supervisor does not own the cell any more; empty if it does.
        """
        self.gate = gate
        self._record = record
        self._loop = loop
        self.tasks = tasks
        self._leases = leases
        self._disowned = disowned
        # ROS time that counts for the run's limit: that of behaviors before this process took over.
        self._before_s = record.state.cell_s
        self._begun_s = loop.now_s()

    @property
    def is_overdue(self) -> bool:
        """Whether the run's time limit has passed."""
        spent_s = self._before_s + self._loop.now_s() - self._begun_s
        return 0 < self._record.state.timeout_s < spent_s

    @property
    def circumstances(self) -> Circumstances:
        """What closes the gate now besides the state of the run."""
        return Circumstances(
            disowned=self._disowned(),
            lost_lease=self._leases.lost,
            is_taken_over=self._leases.is_taken_over,
            is_overdue=self.is_overdue,
            unrested=self.tasks.unrested,
        )

    def update(self) -> None:
        """Close or open the gate as everything requires that is known now."""
        self.tasks.check()
        state, now = self._record.state, self.circumstances
        self.gate.hold, self.gate.halt = decide_hold(state, now), decide_halt(state, now)

    def enter(self, name: str, what: str) -> None:
        """Return when something may begin that the use case supervisor makes move.

        Args:
            name: under which its end will be reported to the gate.
            what: for a person.

        Raises:
            HaltedError: if it may not.
        """
        if why := self._record.insist(self.tasks.report_stops):
            raise HaltedError(why)
        while (permit := self.gate.ask(name, what)) is Permit.HELD:
            self._loop.run_until(lambda: not self.gate.hold or bool(self.gate.halt), _CHECK_S)
        if permit is Permit.REFUSED:
            raise HaltedError(self.gate.halt)


# [s] wall time after which something that is gone counts as lost.
_GRACE_S = 0.2

# [s] wall time that what runs gets to come to rest when this process ends; roslaunch waits for 15.
_LEAVE_LIMIT_S = 4.0


class Reconnection:
    """Brings a run to a state from which it can go on."""

    def __init__(
        self,
        record: RunRecord,
        loop: EventLoop,
        peers: Peers,
        gates: GateKeeper,
        describe: Callable[[str], None],
    ) -> None:
        """Take the run's record, and what may be lost.

        Args:
            record: of the run.
            loop: time, and what arrives.
            peers: processes that the run needs.
            gates: run behaviors, and close the gate.
            describe: publishes what is waited for.
        """
        self._record = record
        self._loop = loop
        self._peers = peers
        self._gates = gates
        self._describe = describe

    def recover(self, because: str, limit_s: float, *, is_interrupted: bool = True) -> bool:
        """Wait for what was lost, and stop what runs; its progress is unverified.

        Args:
            because: what was lost.
            limit_s: [s] wall time that it gets to answer again.
            is_interrupted: whether the run was under way; otherwise it is about to begin.

        Returns:
            Whether everything answers and rests; otherwise the run is blocked.
        """
        # With the launch everything ends at once, this process not first: that is no event.
        self._loop.run_until(lambda: False, _GRACE_S)
        if is_interrupted:
            self._record.append(Interrupted(because))
            self._describe(f"waiting, since {because}")
        try:
            self._peers.wait(limit_s)
            self._gates.tasks.stop_all(limit_s)
        except LostError as error:
            self._record.append(Blocked(str(error)))
            return False
        return True

    def await_ownership(self, disowned: Callable[[], str]) -> None:
        """Wait while the lease on the cell has run out: nothing moves before it is renewed."""
        while lost := disowned():
            self._describe(f"waiting, since {lost}")
            self._record.take_up()
            self._loop.run_until(lambda: not disowned(), RETRY_S)

    def come_to_rest(self, because: str) -> str:
        """Stop what runs before this process, or its ownership, ends; return what does not rest."""
        self._gates.gate.halt = because
        try:
            self._gates.tasks.stop_own(_LEAVE_LIMIT_S)
        except LostError as lost:
            return str(lost)
        return ""
