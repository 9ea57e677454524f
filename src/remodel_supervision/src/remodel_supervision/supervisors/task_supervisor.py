"""The task supervisor: runs one behavior, grants its operations, and keeps what they did."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from remodel_production.errors import LostError, PlannerError
from remodel_states.core.codes import Code
from remodel_states.core.contract import owner_of
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.gate import FEEDER, Gate, Permit
from remodel_supervision.core.runs.state import FINISHED, PERSON_FIRST, PREEMPTED, SERVER_GONE
from remodel_supervision.supervisors.ports import (
    Abilities,
    BehaviorEnd,
    Cell,
    EndKind,
    Engine,
    EventLoop,
    server_of,
)

# [s] wall time between two checks of what no node reports, such as silence.
_CHECK_S = 0.1

# [s] wall time that a behavior gets to stop when it is asked to.
STOP_LIMIT_S = 20.0

# [s] wall time that the engine's topic may lag behind the end of a behavior.
_LAG_LIMIT_S = 2.0

Keep = Callable[[Operation], None]


class TaskSupervisor:
    """Runs behaviors, one at a time.

    Attributes:
        behavior: name of the one that runs; empty if none does.
        halted: why the gate stopped the one started last; empty if it did not.
    """

    def __init__(
        self,
        loop: EventLoop,
        engine: Engine,
        abilities: Abilities,
        cell: Cell,
        gate: Gate,
        report_stop: Keep,
        owner: int = 0,
        superseded: Callable[[], bool] = lambda: False,
    ) -> None:
        """Take the ports, and the gate that its operations pass.

        Args:
            loop: time, and what arrives.
            engine: that runs behaviors.
            abilities: that the cell has.
            cell: its services.
            gate: that all operations pass.
            report_stop: keeps an operation of a behavior that was given up, after which a person
                is to answer first; raises PlannerError if it cannot.
            owner: token by which this supervisor owns the cell.
            superseded: returns whether another supervisor may be at work, since this one has lost
                the cell or its task, or is to end.
        """
        self.behavior = ""
        self.halted = ""
        self._owner = owner
        self._report_stop = report_stop
        self._superseded = superseded
        self._has_started = False
        self._loop = loop
        self._engine = engine
        self._abilities = abilities
        self._cell = cell
        self._gate = gate
        self._keep: Keep | None = None
        self._kept: Counter[str] = Counter()
        self._goals: set[str] = set()
        # Operations after which a person is to answer first: ids of the goals of this behavior
        # that are known to the run, and results whose records have not arrived.
        self._stops_kept: set[str] = set()
        self._stops_heard: dict[str, Operation] = {}
        # Why nothing more of the behavior may begin; empty if it may.
        self._why_over = ""
        # Operations whose server may still do them: path of the state -> ability, and since when.
        self._unended: dict[str, tuple[str, float]] = {}
        self._is_cut = False
        self._settling = True
        self._awaits_feeder = False

    @property
    def is_still(self) -> bool:
        """Whether nothing moves, and that is known."""
        return self._gate.is_still and not self.is_settling

    @property
    def is_settling(self) -> bool:
        """Whether it is not known what moves: at first, and after a loss, until all of it rests."""
        return self._settling

    @property
    def unrested(self) -> tuple[str, ...]:
        """Servers that were lost during an operation, and may still complete it; for a person."""
        return tuple(dict.fromkeys(server_of(ability) for ability, _ in self._unended.values()))

    def restless(self, since_s: float) -> str:
        """Return what does not rest although it should, for a person.

        Args:
            since_s: [s] wall time at which rest was asked for.
        """
        names = list(self.unrested)
        if FEEDER in self._gate.moving or self._awaits_feeder:
            names.append("the feeder")
        if self._settling or self._gate.halt:
            names += self._abilities.restless(since_s)
            names += [] if self._engine.is_idle else ["the behavior engine"]
        return ", ".join(dict.fromkeys(names))

    def run(self, behavior: str, keep: Keep) -> str:
        """Run a behavior to its end, and return its outcome; stop it when the gate halts.

        Args:
            behavior: its name.
            keep: keeps each operation when it has ended; the behavior goes on when it has.

        Raises:
            LostError: if engine or action server are lost; the progress of its task is unverified.
            LeavingError: if this process is to end.
        """
        self.halted = self._gate.halt or self.report_stops()
        if self.halted:
            return PREEMPTED
        self.behavior, self._keep, self._why_over = behavior, keep, ""
        self._is_cut = False
        self._kept.clear()
        self._goals.clear()
        # The next execution of a behavior counts its goals from 1 again.
        self._stops_kept.clear()
        self._has_started = True
        try:
            self._engine.start(behavior)
            outcome = self._watch()
            self._await_path()
            for path in self._gate.moving.keys() - self._unended.keys():
                self._gate.end(path)
            self.report_stops()
            # It failed since an operation was refused, before it could be stopped.
            return PREEMPTED if self._is_cut and outcome != FINISHED else outcome
        finally:
            self.behavior, self._keep = "", None

    def stop_all(self, limit_s: float) -> None:
        """Stop whatever runs, and return when engine, abilities and cell report that they rest.

        Args:
            limit_s: [s] wall time that it gets.

        Raises:
            LostError: if one of them does not rest in time.
        """
        self._settling = True
        end_s = self._loop.wall_s() + limit_s
        if not self._engine.is_idle:
            self._engine.cancel()
        self._abilities.cancel()
        self._rest(lambda: self._engine.is_idle, end_s, lambda: "the behavior engine")
        since_s = self._loop.wall_s()
        self._rest(
            lambda: self._abilities.are_quiet(since_s),
            end_s,
            lambda: ", ".join(self._abilities.restless(since_s)),
        )
        self._awaits_feeder = True
        try:
            self._take_over_cell(end_s)
        finally:
            self._awaits_feeder = False
        self._gate.clear()
        self._unended.clear()
        self.report_stops()
        self._settling = False

    def stop_own(self, limit_s: float) -> None:
        """Stop what this supervisor has begun, before its process or its ownership ends.

        Another supervisor may own the cell by now: what that one has begun goes on.

        Args:
            limit_s: [s] wall time that it gets.

        Raises:
            LostError: if something does not rest in time.
        """
        self._settling = True
        end_s = self._loop.wall_s() + limit_s
        self._engine.cancel(own_only=True)
        self._abilities.cancel(self._owner)
        self._rest(
            lambda: not self._has_started or self._engine.end is not None,
            end_s,
            lambda: "the behavior engine",
            while_leaving=True,
        )
        since_s = self._loop.wall_s()
        self._rest(
            lambda: self._abilities.are_quiet(since_s, self._owner),
            end_s,
            lambda: ", ".join(self._abilities.restless(since_s, self._owner)),
            while_leaving=True,
        )
        self._gate.clear()
        self._settling = False
        self.report_stops()

    def report_stops(self) -> str:
        """Report results after which a person is to answer first, and whose records are not kept.

        A record is lost when the engine ends before it is kept, and says that the operation was
        cancelled when its state is left meanwhile. While a behavior runs, its record is waited for.

        Returns:
            Why nothing may begin; empty if there is no such result.

        Raises:
            PlannerError: if it cannot be kept.
        """
        self._hear()
        why = ""
        for goal_id, operation in list(self._stops_heard.items()):
            self._report_stop(operation)
            del self._stops_heard[goal_id]
            self._stops_kept.add(goal_id)
            why = _person_needed(operation)
        return why

    def note_stop(self, goal_id: str) -> None:
        """Note that a person is asked because of a goal that this supervisor has sent itself."""
        self._stops_kept.add(goal_id)

    def _hear(self) -> None:
        for operation in self._abilities.take_stops():
            if operation.goal_id not in self._stops_kept:
                self._stops_heard[operation.goal_id] = operation

    def begin_operation(self, behavior: str, state_path: str, ability: str) -> tuple[Permit, str]:
        """Return whether an ability may begin, and why not.

        Args:
            behavior: name of the behavior that asks.
            state_path: of the state that asks.
            ability: such as "InsertCable".
        """
        if self._settling or self.halted or behavior != self.behavior:
            return Permit.REFUSED, f"behavior {behavior!r} is about to be stopped"
        self._hear()
        for stop in self._stops_heard.values():
            self._why_over = _person_needed(stop)
        if self._why_over:
            return Permit.REFUSED, self._why_over
        permit = self._gate.ask(state_path, ability)
        self._is_cut = self._is_cut or permit is Permit.REFUSED
        return permit, self._gate.why

    def keep_record(self, behavior: str, operation: Operation) -> tuple[bool, str]:
        """Keep what an operation did; return whether the state may go on, and why not.

        A record of a behavior that was, or is about to be, stopped is accepted and dropped: what
        that behavior has done is inspected, nothing more of it is granted, and its state would
        send the record again to the next behavior of the same name. Only if a person is to answer
        before anything moves, that is kept.
        """
        if operation.goal_id in self._stops_kept and operation.goal_id not in self._goals:
            return True, "the operation was reported before; its record is not kept again"
        if self._settling or self._is_of_another_owner(operation):
            return self._keep_stop(
                operation, "the record is of a behavior that was stopped, and is not kept"
            )
        if self._keep is None or behavior != self.behavior:
            return self._keep_stop(operation, "the record is of no running task, and is not kept")
        if operation.goal_id not in self._goals:
            try:
                self._keep(operation)
            except PlannerError as error:
                return False, str(error)
            self._goals.add(operation.goal_id)
            if operation.error_code in PERSON_FIRST:
                self._note_stop(operation)
            self._kept[operation.state_path] += 1
        if operation.error_code in SERVER_GONE:
            self._why_over = f"the server of {operation.ability} is lost"
        elif operation.error_code in PERSON_FIRST:
            self._why_over = _person_needed(operation)
        if operation.error_code in SERVER_GONE or not operation.outcome:
            # A goal that was given up is cancelled; the server has not reported its end.
            self._unended[operation.state_path] = operation.ability, self._loop.wall_s()
        else:
            self._gate.end(operation.state_path)
        return True, ""

    def check(self) -> None:
        """Learn which servers that were lost rest by now, or have ended."""
        for path, (ability, since_s) in list(self._unended.items()):
            is_connected = self._abilities.is_connected(ability)
            if not is_connected or self._abilities.answers(ability, since_s):
                del self._unended[path]
                self._gate.end(path)

    def _keep_stop(self, operation: Operation, otherwise: str) -> tuple[bool, str]:
        """Keep what a person is to answer first; return whether the state may go on, and why not.

        That a server refuses the goal of an earlier owner of the cell is as it should be.
        """
        if operation.error_code not in PERSON_FIRST - {Code.STALE_OWNER}:
            return True, otherwise
        try:
            self._report_stop(operation)
        except PlannerError as error:
            return False, str(error)
        self._note_stop(operation)
        return True, ""

    def _note_stop(self, operation: Operation) -> None:
        self._stops_kept.add(operation.goal_id)
        self._stops_heard.pop(operation.goal_id, None)

    def _is_of_another_owner(self, operation: Operation) -> bool:
        """Return whether a supervisor before this one granted an operation."""
        token = owner_of(operation.goal_id)
        return token not in (0, self._owner)

    def _watch(self) -> str:
        end = self._ended(lambda: bool(self._gate.halt))
        # It may also have ended because its goals were refused or cancelled, before it was stopped.
        self.halted = self._gate.halt
        if end is None or self.halted:
            end = self._halted()
        if end.end is EndKind.LOST:
            raise LostError(end.text)
        is_stopped = end.end is EndKind.PREEMPTED or (bool(self.halted) and end.text != FINISHED)
        return PREEMPTED if is_stopped else end.text

    def _halted(self) -> BehaviorEnd:
        """Stop what runs, and return how the behavior ended when nothing moves any more.

        What a supervisor has begun that has superseded this one goes on.
        """
        owner = self._owner if self._superseded() else None
        self._engine.cancel(own_only=owner is not None)
        self._abilities.cancel(owner)
        late_s = self._loop.wall_s() + STOP_LIMIT_S
        end = self._ended(lambda: self._loop.wall_s() > late_s)
        since_s = self._loop.wall_s()
        limit_s = max(0.0, late_s - since_s)
        if end is None:
            raise LostError(f"the behavior does not stop within {STOP_LIMIT_S:.0f} s")
        if not self._loop.run_until(lambda: self._abilities.are_quiet(since_s, owner), limit_s):
            names = ", ".join(self._abilities.restless(since_s, owner))
            raise LostError(f"{names} does not stop")
        return end

    def _ended(self, or_until: Callable[[], bool]) -> BehaviorEnd | None:
        """Return how the behavior ended; None if something else holds before."""
        while self._engine.end is None:
            if or_until():
                return None
            if self._engine.trouble:
                raise LostError(self._engine.trouble)
            self._loop.run_until(lambda: self._engine.end is not None or or_until(), _CHECK_S)
        return self._engine.end

    def _take_over_cell(self, end_s: float) -> None:
        """Wait until nothing moves that this or an earlier owner asked the cell's services for."""
        while True:
            try:
                if self._cell.take_over(self._owner):
                    return
                why = "the cell still moves"
            except LostError as error:
                why = str(error)
            if self._loop.wall_s() >= end_s:
                raise LostError(f"{why}; stop the cell by hand")
            self._loop.run_until(lambda: False, _CHECK_S)

    def _await_path(self) -> None:
        """Wait until the engine has published, on another topic, which states it has entered."""
        self._loop.run_until(
            lambda: not self._kept - Counter(self._engine.path()),
            _LAG_LIMIT_S,
        )

    def _rest(
        self,
        holds: Callable[[], bool],
        end_s: float,
        what: Callable[[], str],
        *,
        while_leaving: bool = False,
    ) -> None:
        limit_s = max(0.0, end_s - self._loop.wall_s())
        if not self._loop.run_until(holds, limit_s, while_leaving=while_leaving):
            raise LostError(
                f"{what()} still runs, or does not answer, {limit_s:.0f} s after it was stopped; "
                "stop the cell by hand"
            )


def _person_needed(operation: Operation) -> str:
    return f"{operation.ability} ended with error {operation.error_code}; a person is needed"
