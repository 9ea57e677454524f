"""The use case supervisor: does what core/runs derives, and keeps what happens."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_planning.core.problem.problem import End as WireEnd
from remodel_planning.core.task_charts.planned_tasks import PlannedTask
from remodel_planning.errors import UseCaseError
from remodel_production.errors import InstanceError, LostError
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Answered,
    AsLeft,
    Blocked,
    Chosen,
    Command,
    Commanded,
    FeedRefused,
    Interrupted,
    OperationEnded,
    PanelLoaded,
    Part,
    PartRequested,
    Planned,
    RunEnded,
    Settled,
    StopReported,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_supervision.core.runs.gate import FEEDER, Gate, Permit
from remodel_supervision.core.runs.state import (
    PERSON_FIRST,
    PREEMPTED,
    RunState,
    Stage,
    TaskProgress,
)
from remodel_supervision.core.runs.step import (
    Ask,
    Decide,
    End,
    Execute,
    Plan,
    Settle,
    Step,
    Wait,
    description_of,
    next_step,
)
from remodel_supervision.edge.task_leases import Holding
from remodel_supervision.errors import CellError, HaltedError, LeavingError, RefusedError
from remodel_supervision.supervisors.commands import (
    PendingReplies,
    Reply,
    require_open,
    require_sense,
)
from remodel_supervision.supervisors.failure_judge import FailureJudge
from remodel_supervision.supervisors.leases import LeaseKeeper
from remodel_supervision.supervisors.ports import Doing, EventLoop, Log, UnseenError
from remodel_supervision.supervisors.run_record import RETRY_S, RunRecord
from remodel_supervision.supervisors.task_supervisor import TaskSupervisor
from remodel_supervision.supervisors.work import Peers, Work

# [s] wall time between two checks of what nobody reports: other cells' tasks, the run's time.
_CHECK_S = 0.2

# [s] wall time between two questions to the database whether other cells are done with a task.
_OTHERS_S = 1.0

# [s] wall time after which something that is gone counts as lost.
_GRACE_S = 0.2

# [s] wall time that what runs gets to come to rest when this process ends; roslaunch waits for 15.
_LEAVE_LIMIT_S = 4.0

# A cell's answer to a claim -> how the other cell has left the task.
_AS_LEFT = {
    Holding.ELSEWHERE: AsLeft.RUNNING,
    Holding.DONE: AsLeft.DONE,
    Holding.SET_ASIDE: AsLeft.SET_ASIDE,
}

# What the supervisor itself makes move passes the gate under this name.
_OWN = "supervisor"


class UseCaseSupervisor:
    """Takes one run to its end.

    Attributes:
        tasks: the task supervisor below, which answers the states of behaviors.
    """

    def __init__(
        self,
        run: int,
        owner: int,
        state: RunState,
        loop: EventLoop,
        log: Log,
        work: Work,
        peers: Peers,
        on_change: Callable[[], None],
        disowned: Callable[[], str] = lambda: "",
    ) -> None:
        """Take over a run.

        Args:
            run: its number.
            owner: token by which this supervisor owns the cell.
            state: what is known of the run.
            loop: time, and what arrives.
            log: keeps its events.
            work: what it is about.
            peers: processes that it needs.
            on_change: called when state or doing have changed.
            disowned: returns why this supervisor does not own the cell any more; empty if it does.
        """
        self.run = run
        self.owner = owner
        self._doing = ""
        self.work = work
        self._loop = loop
        self._peers = peers
        self._on_change = on_change
        self._disowned = disowned
        self._gate = Gate()
        self.tasks = TaskSupervisor(
            loop, peers.engine, peers.abilities, self._gate, self._report_stop, owner, disowned
        )
        self._lease = LeaseKeeper(loop, work.leases, self._close_or_open)
        self._replies = PendingReplies(loop.wall_s)
        self._behaviors_ended = 0
        # ROS time that counts for the run's limit: that of behaviors before this process took over.
        self._before_s = state.cell_s
        self._begun_s = 0.0
        # A run whose order of tasks is decided was supervised by another process before.
        self._is_resumed = self._is_planned = not state.to_plan
        # Where the cell answered that has the panel.
        self._loaded_at = ""
        self._step: Step | None = None
        self._record = RunRecord(run, owner, state, log, loop, self._on_state, self._describe)
        self._judge = FailureJudge(
            self._record, loop, log, work, peers.abilities, self._gate, self._describe
        )

    @property
    def state(self) -> RunState:
        """What is known of the run; replaced at each event, never changed."""
        return self._record.state

    @property
    def doing(self) -> str:
        """What is being done now, for a person, and what does not rest although it should."""
        unrested = ", ".join(self.tasks.unrested)
        return f"{self._doing}; not at rest: {unrested}" if unrested else self._doing

    @property
    def doing_now(self) -> Doing | None:
        """What an ability reports that it does; None if none does anything."""
        return self._peers.abilities.latest

    @property
    def state_path(self) -> str:
        """The path of the state in which the engine is; empty if none is known."""
        return self._peers.engine.state_path

    @property
    def is_moving(self) -> bool:
        """Whether something moves that has passed the gate."""
        return not self.tasks.is_still

    def supervise(self) -> RunState:
        """Do what comes next until the run has ended, and return how it ended.

        What is lost meanwhile is waited for, and the run goes on from where it was. A shutdown
        leaves no event.

        Raises:
            LeavingError: if this process is to end; nothing moves any more.
            OwnerError: if another supervisor owns the run; nothing of this one moves any more.
            RecordLostError: if the database has lost the run; nothing moves any more.
        """
        self._begun_s = self._loop.now_s()
        timer = self._loop.every(_CHECK_S, self._tick)
        try:
            self._recover("the use case supervisor was restarted", is_resumed=self._is_resumed)
            while (step := self._next_step()) is not None:
                try:
                    self._do(step)
                except LostError as error:
                    self._recover(str(error))
                except HaltedError as error:
                    self._explain_halt(error)
                except (CellError, InstanceError, UseCaseError) as error:
                    self._record.append(Blocked(str(error)))
        except BaseException as error:
            self._come_to_rest(error)
            raise
        finally:
            timer.cancel()
            self._lease.release()
            self._replies.end("the run has ended")
        return self.state

    def command(self, event: Commanded, reply: Reply) -> None:
        """Do what an operator or a safety controller asks for.

        The reply comes when nothing moves any more: after a pause when the operation under way has
        ended, after a stop of any kind when what ran is cancelled and at rest. If something does
        not rest in time, the reply names it, and nothing else begins before it rests.
        """
        # At first, and after a loss, it is not known which task is under way.
        is_under_way = bool(event.task) and (
            event.task == getattr(self._step, "task", "") or self.tasks.is_settling
        )
        try:
            require_sense(event, self.state)
            self._record.append_now(event)
        except Exception as error:  # noqa: BLE001 - whoever asked gets the reason, whatever it is
            reply(False, str(error))
            return
        if self._gate.halt and not self.tasks.behavior:
            self._peers.abilities.cancel()
        if self._gate.halt and self.tasks.behavior and event.command is not Command.PAUSE:
            ended = self._behaviors_ended + 1
            self._reply_when(lambda: self._behaviors_ended >= ended, reply)
        elif event.command is Command.PAUSE or self._gate.halt or is_under_way:
            self._reply_when(lambda: self.tasks.is_still, reply)
        else:
            reply(True, "")

    def _reply_when(self, holds: Callable[[], bool], reply: Reply) -> None:
        asked_s = self._loop.wall_s()

        def restless() -> str:
            names = self.tasks.restless(asked_s)
            return names or (self.doing if self._gate.halt and not self.tasks.is_still else "")

        self._replies.reply_when(holds, reply, restless)

    def answer(self, event: Answered, reply: Reply) -> None:
        """Take an operator's answer."""
        try:
            require_open(event, self.state)
            self._record.append_now(event)
        except Exception as error:  # noqa: BLE001 - whoever asked gets the reason, whatever it is
            reply(False, str(error))
            return
        reply(True, "")

    # --- steps

    def _do(self, step: Step) -> None:
        self._step = step
        self._describe(description_of(step))
        if self._is_overdue() and not isinstance(step, End):
            limit = f"its time of {self.state.timeout_s:g} s has passed"
            self._record.append(Blocked(limit))
            return
        match step:
            case Plan():
                self._record.append_if_next(step, Planned(self._planned(), step.because))
            case Execute():
                self._execute(step.task, step.part)
            case Settle():
                self._settle(step.task)
            case Decide():
                self._judge.decide(step.task)
            case Ask():
                self._judge.ask(step.task)
            case Wait():
                self._wait()
            case End():
                self._record.append_if_next(step, RunEnded(step.ending, step.because))

    def _planned(self) -> tuple[str, ...]:
        """Return the waiting tasks in their best order; those that were begun before come last."""
        waiting, tasks = self.state.waiting, self.state.tasks
        last = [name for name in waiting if tasks[name].attempts]
        previous = waiting if self._is_planned else ()
        self._is_planned = True
        return self.work.planner.plan(waiting, previous, last)

    def _execute(self, name: str, part: Part) -> None:
        if not self._has(name):
            return
        if part is Part.CLEAR:
            self._judge.await_server(name)
        task = self.state.tasks[name]
        chosen = self._chosen(task, part)
        chart = self.work.planner.chart(name, part, task.connected, task.decisions, chosen)
        self._lease.hold(name)
        try:
            self._close_or_open()
            self._peers.maker.make(chart)
            self._load_panel()
            step = Execute(name, part)
            # A command may come at any time, after which something else is to be done.
            if self._next_step() != step or (part is Part.WHOLE and not self._feed(name)):
                return
            if self._next_step() == step:
                self._run(name, part, chart, chosen)
        finally:
            self._lease.release()

    def _chosen(self, task: TaskProgress, part: Part) -> tuple[Chosen, ...]:
        """Return the parameters by which a task is attempted that learning chose."""
        if not part.is_attempt:
            return ()
        seed = f"run {self.run}, {task.name}, attempt {task.attempts + 1}"
        return self.work.planner.choose(task.name, task.decisions, seed)

    def _feed(self, name: str) -> bool:
        """Have a piece presented; return whether it is there."""
        self._record.append_if_next(Execute(name, Part.WHOLE), PartRequested(name))
        self._pass_gate(FEEDER, f"feeding {name}")
        try:
            self._peers.cell.feed(name, self.work.channels.get(name, ""), self.owner)
        except RefusedError as error:
            self._gate.end(FEEDER)
            self._record.append(FeedRefused(name, error.code, str(error), self._loop.now_s()))
            return False
        except LeavingError:
            raise  # the feeder goes on
        except BaseException:
            self._gate.end(FEEDER)
            raise
        self._gate.end(FEEDER)
        return True

    def _run(self, name: str, part: Part, chart: Chart, chosen: tuple[Chosen, ...]) -> None:
        """Run a behavior of a task, and keep what it does."""
        attempt = self.state.tasks[name].attempts + part.is_attempt
        begun_s = self._loop.now_s()
        xml = write_chart(chart)
        begun = TaskBegun(name, attempt, part, chart.name, xml, begun_s, chosen)
        self._record.append_if_next(Execute(name, part), begun)
        self._close_or_open()
        self._peers.pictures.begin()

        def keep(operation: Operation) -> None:
            self._record.catch_up()
            kept = self.state.tasks[name].operations
            if operation.goal_id in [each.goal_id for each in kept]:
                return  # the answer to its commit was lost
            self._record.append_now(OperationEnded(name, operation))
            self.work.planner.learn(name, operation)

        outcome = self.tasks.run(chart.name, keep)
        self._behaviors_ended += 1
        self._replies.check()
        if outcome == PREEMPTED and self._is_cut_short(name):
            self._explain_cut(name)
            return
        pictures = self._peers.pictures.keep(self.run, f"{name}-{attempt}-{part.value}")
        placed = self._peers.cell.placed(name)
        path = self._peers.engine.path()
        at_s, denied = self._loop.now_s(), placed is False
        self._record.append(TaskEnded(name, outcome, at_s, bool(placed), path, pictures, denied))

    def _is_cut_short(self, name: str) -> bool:
        """Return whether the behavior was stopped by what is neither a stop nor a skip.

        What stopped it may be over by now: a protective stop can be released at once.
        """
        if self._disowned() or self._lease.lost or self.state.protective:
            return True
        is_asked_for = bool(self.state.stop) or name in self.state.skipped
        return bool(self.tasks.halted) and not is_asked_for

    def _explain_cut(self, name: str) -> None:
        """Record why a behavior was cut short; what it has done is in doubt."""
        if self._lease.is_taken:
            self._record.append(TaskElsewhere(name, "", AsLeft.RUNNING))
        else:
            self._record.append(Interrupted(self.tasks.halted))

    def _report_stop(self, operation: Operation) -> None:
        """Keep what an operation of an earlier behavior ended with: a person is to answer first."""
        self._record.catch_up()
        task = self.state.tasks.get(self.state.current)
        if task is None:
            because = f"{operation.ability} ended with error {operation.error_code}: "
            self._record.append_now(Blocked(f"{because}{operation.text}; a person is needed"))
        else:
            known = (*task.operations, *filter(None, [task.stopped_by]))
            stops = [each.goal_id for each in known if each.error_code in PERSON_FIRST]
            if operation.goal_id not in stops:
                self._record.append_now(StopReported(task.name, operation))

    def _settle(self, name: str) -> None:
        if not self._has(name):
            return
        self._load_panel()
        self._close_or_open()
        planned = self.work.planner.task(name, self.state.tasks[name].decisions)
        connected: list[str] = []
        self._pass_gate(_OWN, f"inspecting {name}")
        try:
            self._inspect(name, planned, connected)
            self._gate.end(_OWN)
        except HaltedError:
            self._gate.end(_OWN)
            raise
        except UnseenError as error:
            self._gate.end(_OWN)
            if self._gate.halt:
                raise HaltedError(self._gate.halt) from error
            unseen = Settled(name, tuple(connected), 1, error.code, str(error))
            self._record.append_if_next(Settle(name), unseen, while_paused=True)
            self.tasks.note_stop(error.goal_id)
            return
        settled = Settled(name, tuple(connected), len(planned.left(connected)))
        self._record.append_if_next(Settle(name), settled, while_paused=True)

    def _inspect(self, name: str, planned: PlannedTask, connected: list[str]) -> None:
        """Add the letters of the ends that are in their terminals."""
        task = planned.decomposition.task
        for end in WireEnd:
            terminal = task.terminals[end]
            component = planned.component_of[terminal]
            short = terminal.removeprefix(f"{component}:")
            inspection = self._peers.inspection
            if self._gate.halt:
                raise HaltedError(self._gate.halt)
            if inspection.is_connected(self.owner, name, end.letter, component, short):
                connected.append(end.letter)

    def _wait(self) -> None:
        """Wait for a command, an answer, other cells, or the end of a question's time."""
        before = self.state
        limit_s = _OTHERS_S if before.in_stage(Stage.ELSEWHERE) else _CHECK_S
        self._loop.run_until(lambda: self.state is not before, limit_s)
        if self.state is not before:
            return
        self._judge.escalate()
        for name in self.state.in_stage(Stage.ELSEWHERE):
            claim = self._record.insist(lambda n=name: self.work.leases.claim(n))  # type: ignore[misc]
            if claim.holding in (Holding.DONE, Holding.SET_ASIDE):
                self._record.append(TaskElsewhere(name, claim.cell, _AS_LEFT[claim.holding]))
            elif claim.holding is not Holding.ELSEWHERE:
                self._record.append(TaskReturned(name, claim.cell))

    def _has(self, name: str) -> bool:
        """Return whether this cell has a task; if another one has it, or has had it, keep that."""
        task, leases = self.state.tasks[name], self.work.leases
        if name == self.state.current:
            if self._record.insist(lambda: leases.renew(name)):
                return True
            self._record.append(TaskElsewhere(name, "", AsLeft.RUNNING))
            return False
        claim = self._record.insist(lambda: leases.claim(name))
        if claim.holding is Holding.MINE:
            return True
        if claim.holding is Holding.MINE_IN_DOUBT:
            is_known = task.stage is Stage.DOUBTFUL or (
                task.attempts > 0 and claim.cell == self.state.cell
            )
            if not is_known:
                self._record.append(TaskReturned(name, claim.cell))
            return is_known
        self._record.append(TaskElsewhere(name, claim.cell, _AS_LEFT[claim.holding]))
        return False

    def _load_panel(self) -> None:
        """Have the cell build the product's panel, unless this cell process has it."""
        if self.work.panel is None or self._peers.cell.address() == self._loaded_at:
            return
        state = self.state
        # A cell that began later may have built it first, and placed wires on it.
        keep = state.keep_panel or self._record.insist(self.work.leases.begun_elsewhere)
        self._pass_gate(_OWN, "loading the panel")
        try:
            self._peers.cell.load(self.work.panel, state.serial, self.owner, keep=keep)
        finally:
            self._gate.end(_OWN)
        self._record.append(PanelLoaded(state.serial))
        self._loaded_at = self._peers.cell.address()

    # --- what closes the gate, and what was lost

    def _pass_gate(self, name: str, what: str) -> None:
        """Return when something may begin that this supervisor makes move.

        Raises:
            HaltedError: if it may not.
        """
        if why := self._record.insist(self.tasks.report_stops):
            raise HaltedError(why)
        while (permit := self._gate.ask(name, what)) is Permit.HELD:
            self._loop.run_until(lambda: not self._gate.hold or bool(self._gate.halt), _CHECK_S)
        if permit is Permit.REFUSED:
            raise HaltedError(self._gate.halt)

    def _close_or_open(self) -> None:
        """Bring the gate up to date."""
        state = self.state
        task = state.tasks.get(state.current)
        is_attempt = task is not None and task.stage is Stage.RUNNING and task.part.is_attempt
        by = state.skipped.get(state.current, "") if is_attempt else ""
        protective = f"protective stop by {state.protective}" if state.protective else ""
        overdue = "its time has passed" if self._is_overdue() else ""
        self.tasks.check()
        unrested = ", ".join(self.tasks.unrested)
        self._gate.hold = "the run is paused" if state.paused else ""
        if unrested and not state.paused:
            self._gate.hold = f"not at rest: {unrested}"
        self._gate.halt = (
            self._disowned()
            or protective
            or state.stop
            or self._lease.lost
            or (task.halt if task else "")
            or (f"{by} skipped the task" if by else "")
            or overdue
        )

    def _tick(self) -> None:
        with suppress(LostError):
            self._record.catch_up()
        self._lease.check()
        self._close_or_open()
        self._replies.check()

    def _explain_halt(self, error: HaltedError) -> None:
        """Record why a step did not begin, unless the state of the run says it."""
        if self._lease.is_taken:
            self._record.append(TaskElsewhere(self.state.current, "", AsLeft.RUNNING))
        elif self._lease.lost or self._disowned():
            self._recover(str(error))

    def _recover(self, because: str, *, is_resumed: bool = True) -> None:
        """Wait for what was lost, and stop what runs; what it was doing is in doubt."""
        # With the launch everything ends at once, this process not first: that is no event.
        self._loop.run_until(lambda: False, _GRACE_S)
        if is_resumed:
            self._record.append(Interrupted(because))
            self._describe(f"waiting, since {because}")
        self._loaded_at = ""
        try:
            self._peers.wait(self.work.reconnect_s)
            self.tasks.stop_all(self.work.reconnect_s)
        except LostError as error:
            self._record.append(Blocked(str(error)))
        else:
            self._behaviors_ended += 1
            self._replies.check()

    def _come_to_rest(self, error: BaseException) -> None:
        """Stop what runs before this process, or its ownership, ends."""
        self._gate.halt = str(error) or type(error).__name__
        try:
            self.tasks.stop_own(_LEAVE_LIMIT_S)
        except LostError as lost:
            self._doing = str(lost)

    def _is_overdue(self) -> bool:
        spent_s = self._before_s + self._loop.now_s() - self._begun_s
        return 0 < self.state.timeout_s < spent_s

    def _next_step(self) -> Step | None:
        self._record.insist(self._record.catch_up)
        while lost := self._disowned():
            # The lease on the cell ran out during an outage: nothing moves before it is renewed.
            self._describe(f"waiting, since {lost}")
            self._record.take_up()
            self._loop.run_until(lambda: not self._disowned(), RETRY_S)
        self._close_or_open()
        return next_step(self.state)

    def _on_state(self) -> None:
        self._close_or_open()
        self._on_change()

    def _describe(self, text: str) -> None:
        self._doing = text
        self._on_change()
