"""Keeps the gate up to date, and has what the supervisor itself makes move pass it."""

from __future__ import annotations

from collections.abc import Callable

from remodel_supervision.core.runs.gate import Circumstances, Gate, Permit, decide_halt, decide_hold
from remodel_supervision.errors import HaltedError
from remodel_supervision.supervisors.leases import LeaseKeeper
from remodel_supervision.supervisors.ports import EventLoop
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.task_supervisor import TaskSupervisor

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
