"""The runs of a cell, one at a time: the one that was cut short first, then those of goals.

The cell is acquired before anything is supervised, and its lease renewed from then on.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection
from typing import Protocol

from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.errors import LostError, OwnerError, PlannerError, RecordLostError
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import RunBegun
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.errors import CellError, LeavingError
from remodel_supervision.supervisors.ports import EventLoop, Peers, Work
from remodel_supervision.supervisors.run_commands import RunCommands, UnresumedRun
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor

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


# Why no goal is taken at first.
STARTING = "the supervisor is starting; send the order again in a moment"


class WorkSource(Protocol):
    """Makes what a run is about."""

    def work(self, name: str, use_case: str, tasks: int | Collection[str], owner: int) -> Work:
        """Make the work of an order; PlannerError if that fails.

        Args:
            name: of the order.
            use_case: name of the use case; empty: the default.
            tasks: how many, from the first of those that are not by hand; 0 for all. Or the names
                of those that a run began with.
            owner: token of the ownership of the cell.
        """


class RunObserver(Protocol):
    """Publishes what happens to the runs of a cell."""

    def on_idle(self, text: str, *, starting: bool) -> None:
        """Publish that there is no run.

        Args:
            text: why no goal is taken; empty if one is.
            starting: whether that is due to this node, not to a protective stop.
        """

    def on_resume(self, run: int, state: RunState) -> None:
        """Publish that a run is about to be resumed."""

    def on_begin(self, supervisor: UseCaseSupervisor) -> None:
        """Have states ask this supervisor before they begin, and publish the run."""

    def on_change(self) -> None:
        """Publish what has changed in the run under way."""

    def on_end(self, supervisor: UseCaseSupervisor) -> None:
        """Publish how the run under way has ended."""

    def on_give_up(self, error: PlannerError) -> None:
        """Publish why the run under way, if there is one, is not supervised any more."""


def run_begun(order: str, work: Work, cell: str, timeout_s: float = 0.0) -> RunBegun:
    """Return the event by which a run of some work in a cell begins; see CellRuns.begin."""
    wanted = work.planner.order
    return RunBegun(
        order,
        work.planner.use_case.name,
        cell,
        tuple(task.name for task in wanted.tasks),
        timeout_s=timeout_s,
        cables={core: name for name, cores in wanted.cables.items() for core in cores},
        by_hand=work.by_hand,
    )


class CellRuns:
    """Supervises the runs of a cell."""

    def __init__(
        self,
        cell: OwnedCell,
        loop: EventLoop,
        log: RunLog,
        source: WorkSource,
        peers: Peers,
        commands: RunCommands,
        observer: RunObserver,
    ) -> None:
        """Begin without a run.

        Args:
            cell: that is acquired first.
            loop: on which everything is done.
            log: keeps the runs.
            source: makes what a run is about.
            peers: processes that runs need.
            commands: reach the run under way.
            observer: publishes what happens.
        """
        self._cell = cell
        self._loop = loop
        self._log = log
        self._source = source
        self._peers = peers
        self._commands = commands
        self._observer = observer
        # Whether the cell may have a run that has not ended and that no process supervises.
        self._unsure = True
        self._next: UseCaseSupervisor | None = None
        commands.closed = STARTING

    def serve(self) -> None:
        """Supervise runs until this process is to end."""
        try:
            while True:
                try:
                    self._cell.acquire(self._wait_for_cell)
                    self._supervise_runs()
                except (OwnerError, RecordLostError) as error:
                    self._give_up(error)
        except LeavingError:
            self._cell.release()

    def require_free(self) -> None:
        """Return if a run can begin; CellError if one is under way, or the cell is closed."""
        under_way = self._commands.active or self._next
        if under_way is not None:
            order = under_way.state.order
            raise CellError(f"run {under_way.run} of order {order} is under way")
        if self._commands.closed:
            raise CellError(self._commands.closed)

    def begin(
        self,
        order: str,
        tasks: int,
        timeout_s: float = 0.0,
        *,
        use_case: str = "",
        again: bool = False,
    ) -> UseCaseSupervisor:
        """Begin a run; it is supervised next.

        Args:
            order: name of the order.
            tasks: how many, from the first; 0 for all.
            timeout_s: [s] ROS time after which the run stops; 0: never.
            use_case: name of the use case that it is done by; empty: the default.
            again: wire the next product of the order; otherwise the current one, or the first.

        Raises:
            PlannerError: if the order cannot be done; there is no run.
        """
        try:
            work = self._source.work(order, use_case, tasks, self._cell.token)
            begun = run_begun(order, work, self._cell.name, timeout_s)
            run, begun = self._begun(begun, again=again)
        except OwnerError as error:
            self._cell.taken_over = str(error)
            raise
        self._next = self._supervisor(run, state_after([begun]), work)
        return self._next

    def _begun(self, begun: RunBegun, *, again: bool) -> tuple[int, RunBegun]:
        try:
            return self._log.begin(begun, self._cell.token, again=again)
        except LostError as error:
            self._unsure = True
            raise LostError(f"{error}; if the run was begun nevertheless, it is done") from error

    def _close(self, text: str, *, starting: bool = True) -> None:
        """Take no goals, for a reason; take them if it is empty."""
        self._commands.closed = text
        self._observer.on_idle(text, starting=starting)

    def _wait_for_cell(self, because: str) -> None:
        if because != self._commands.closed:
            self._close(because)

    def _supervise_runs(self) -> None:
        self._unsure = True
        while True:
            if self._unsure:
                self._resume()
            self._await_goal()
            if self._next is not None:
                self._supervise(self._next)
            elif not self._unsure:
                raise OwnerError(self._cell.taken_over)

    def _await_goal(self) -> None:
        """Return when there is a goal, or none can be taken before something else is done."""

        def is_over() -> bool:
            return self._next is not None or self._unsure or bool(self._cell.taken_over)

        def is_outdated() -> bool:
            return self._commands.closed != self._commands.safety

        while not is_over():
            self._close(self._commands.safety, starting=False)
            self._loop.run_until(lambda: is_over() or is_outdated(), float("inf"))

    def _resume(self) -> None:
        """Take the cell's run to its end that was cut short, or begun without an answer."""
        unfinished = self._log.unfinished(self._cell.name)
        self._unsure = False
        supervisor = None if unfinished is None else self._resumed(unfinished)
        if supervisor is not None:
            self._supervise(supervisor)

    def _resumed(self, run: int) -> UseCaseSupervisor | None:
        """Return the supervisor of a run that was cut short; None after a person has acted."""
        self._log.take_up(run, self._cell.token)
        state = self._log.state(run)
        self._observer.on_resume(run, state)
        try:
            work = self._source.work(
                state.order, state.use_case, tuple(state.tasks), self._cell.token
            )
        except (LostError, OwnerError, RecordLostError):
            raise
        except PlannerError as error:
            token = self._cell.token
            self._await_person(UnresumedRun(run, token, state, self._log, because=str(error)))
            return None
        return self._supervisor(run, state, work)

    def _await_person(self, unresumed: UnresumedRun) -> None:
        """Keep a run that cannot be resumed, and refuse goals, until a person has acted."""
        self._peers.engine.cancel()
        self._peers.abilities.cancel()
        self._close(unresumed.text)
        self._commands.unresumed = unresumed
        try:
            self._loop.run_until(
                lambda: unresumed.is_over or bool(self._cell.taken_over), float("inf")
            )
        finally:
            self._commands.unresumed = None
        self._unsure = True
        if self._cell.taken_over:
            raise OwnerError(self._cell.taken_over)

    def _supervisor(self, run: int, state: RunState, work: Work) -> UseCaseSupervisor:
        return UseCaseSupervisor(
            RunRecord(run, self._cell.token, state, self._log, loop=self._loop),
            self._loop,
            work,
            self._peers,
            on_change=self._observer.on_change,
            disowned=self._cell.disowned,
        )

    def _supervise(self, supervisor: UseCaseSupervisor) -> None:
        self._commands.active, self._next = supervisor, None
        self._observer.on_begin(supervisor)
        self._commands.stop_if_unsafe()
        self._observer.on_change()
        supervisor.supervise()
        self._commands.active = None
        self._observer.on_end(supervisor)

    def _give_up(self, error: PlannerError) -> None:
        """Supervise the run under way no more: this process does not own the cell, or the run."""
        self._observer.on_give_up(error)
        self._commands.active = None
        self._cell.give_up()
        self._close(str(error))
        if isinstance(error, RecordLostError):
            self._loop.run_until(lambda: False, ACQUIRE_EVERY_S)
