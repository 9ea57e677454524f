"""Stops what runs when something was lost or this process ends, and waits for what was lost."""

from __future__ import annotations

from collections.abc import Callable

from remodel_production.errors import LostError
from remodel_supervision.core.runs.events import Blocked, Interrupted
from remodel_supervision.supervisors.gate_keeper import GateKeeper
from remodel_supervision.supervisors.ports import EventLoop, Peers
from remodel_supervision.supervisors.run_record import RETRY_S, RunRecord

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
