"""The use case supervisor: takes one run to its end, step by step as core/runs derives them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from remodel_production.errors import InstanceError, LostError
from remodel_supervision.core.runs.events import (
    Answered,
    Blocked,
    Commanded,
    Part,
    Planned,
    RunEnded,
)
from remodel_supervision.core.runs.gate import Gate
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.core.runs.step import (
    Ask,
    Decide,
    EndRun,
    Execute,
    Plan,
    Settle,
    Step,
    Wait,
    description_of,
    next_step,
)
from remodel_supervision.errors import CellError, HaltedError, RefusedError
from remodel_supervision.supervisors.failure_judge import FailureJudge
from remodel_supervision.supervisors.gate_keeper import GateKeeper, LeaseKeeper, Reconnection
from remodel_supervision.supervisors.ports import EventLoop, Peers, Work
from remodel_supervision.supervisors.run_control import Reply, RunControl
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.task_executor import PanelLoader, TaskExecutor, TaskInspector
from remodel_supervision.supervisors.task_supervisor import TaskSupervisor
from remodel_tasks.errors import UseCaseError

# [s] wall time between two checks of what no node reports: other cells' tasks, the run's time.
_CHECK_S = 0.2

# [s] wall time between two questions to the database whether other cells are done with a task.
_OTHERS_S = 1.0


class UseCaseSupervisor:
    """Takes one run to its end.

    Attributes:
        run: its number.
        owner: token by which this supervisor owns the cell.
        work: what the run is about.
        tasks: the task supervisor below, which answers the states of behaviors.
    """

    def __init__(
        self,
        record: RunRecord,
        loop: EventLoop,
        work: Work,
        peers: Peers,
        on_change: Callable[[], None],
        disowned: Callable[[], str] = lambda: "",
    ) -> None:
        """Take over a run.

        Args:
            record: of the run.
            loop: time, and what arrives.
            work: what the run is about.
            peers: processes that it needs.
            on_change: called when state or doing have changed.
            disowned: returns why this supervisor does not own the cell any more; empty if it does.
        """
        self.run = record.run
        self.owner = record.owner
        self.work = work
        self._record = record
        self._loop = loop
        self._peers = peers
        self._on_change = on_change
        self._disowned = disowned
        self._doing = ""
        self._step: Step | None = None
        # A run whose order of tasks is decided was supervised by another process before.
        self._is_resumed = self._is_planned = not record.state.to_plan
        gate, abilities = Gate(), peers.abilities
        self.tasks = TaskSupervisor(
            loop,
            peers.engine,
            abilities,
            peers.cell,
            gate,
            report_stop=record.report_stop,
            owner=record.owner,
            superseded=lambda: loop.is_leaving or bool(disowned() or self._leases.lost),
        )
        self._leases = LeaseKeeper(loop, work.leases, record, lambda: self._gates.update())
        self._gates = gates = GateKeeper(
            gate, record, loop, self.tasks, leases=self._leases, disowned=disowned
        )
        self._control = RunControl(record, loop, gates, abilities, doing=lambda: self.doing)
        self._panel = PanelLoader(record, work, peers.cell, gates)
        self._inspector = TaskInspector(record, work.planner, peers.inspection, gates)
        on_end = self._control.note_behavior_end
        self._executor = TaskExecutor(
            record, loop, work, peers, gates=gates, on_behavior_end=on_end
        )
        self._judge = FailureJudge(
            record, loop, work, abilities, gate=gate, describe=self._describe
        )
        self._reconnection = Reconnection(record, loop, peers, gates, describe=self._describe)
        record.watch(self._on_state, self._describe)

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
    def is_moving(self) -> bool:
        """Whether something moves that has passed the gate."""
        return not self.tasks.is_still

    def command(self, event: Commanded, reply: Reply) -> None:
        """Do what an operator or a safety controller asks for; see RunControl.command."""
        self._control.command(event, getattr(self._step, "task", ""), reply)

    def answer(self, event: Answered, reply: Reply) -> None:
        """Take an operator's answer."""
        self._control.answer(event, reply)

    def supervise(self) -> RunState:
        """Do what comes next until the run has ended, and return how it ended.

        What is lost meanwhile is waited for, and the run goes on from where it was. A shutdown
        leaves no event.

        Raises:
            LeavingError: if this process is to end; nothing moves any more.
            OwnerError: if another supervisor owns the run; nothing of this one moves any more.
            RecordLostError: if the database has lost the run; nothing moves any more.
        """
        timer = self._loop.every(_CHECK_S, self._tick)
        try:
            self._recover("the use case supervisor was restarted", is_interrupted=self._is_resumed)
            while (step := self._next_step()) is not None:
                try:
                    self._do(step)
                except LostError as error:
                    self._recover(str(error))
                except HaltedError as error:
                    if self._disowned():
                        self._recover(str(error))
                except (CellError, InstanceError, UseCaseError) as error:
                    self._record.append(Blocked(str(error)))
        except BaseException as error:
            restless = self._reconnection.come_to_rest(str(error) or type(error).__name__)
            self._doing = restless or self._doing
            raise
        finally:
            timer.cancel()
            self._control.end()
        return self.state

    # --- steps

    def _next_step(self) -> Step | None:
        self._record.insist(self._record.catch_up)
        self._reconnection.await_ownership(self._disowned)
        self._gates.update()
        return next_step(self.state)

    def _do(self, step: Step) -> None:
        self._step = step
        self._describe(description_of(step))
        if self._gates.is_overdue and not isinstance(step, EndRun):
            limit = f"the run's time limit of {self.state.timeout_s:g} s has passed"
            self._record.append(Blocked(limit))
            return
        match step:
            case Plan():
                self._record.append_if_next(step, Planned(self._planned(), step.because))
            case Execute():
                self._execute(step)
            case Settle():
                if self._leases.claim(step.task):
                    self._panel.load()
                    self._inspector.inspect(step.task)
            case Decide():
                self._judge.decide(step.task)
            case Ask():
                self._judge.ask(step.task)
            case Wait():
                self._wait()
            case EndRun():
                self._record.append_if_next(step, RunEnded(step.ending, step.because))

    def _planned(self) -> tuple[str, ...]:
        """Return the waiting tasks in their best order; those that were begun before come last."""
        waiting, tasks = self.state.waiting, self.state.tasks
        last = [name for name in waiting if tasks[name].attempts]
        previous = waiting if self._is_planned else ()
        self._is_planned = True
        return self.work.planner.plan(waiting, previous, last)

    def _execute(self, step: Execute) -> None:
        """Run a behavior of a task, with everything that it needs."""
        if not self._leases.claim(step.task):
            return
        if step.part is Part.CLEAR:
            self._judge.await_server(step.task)
        chart, chosen = self._executor.chart(step)
        with self._leases.held(step.task):
            self._gates.update()
            self._peers.maker.make(chart)
            try:
                self._panel.load()
            except RefusedError:
                self._leases.give_back(step.task)
                raise
            # A command may come at any time, after which something else is to be done.
            if self._next_step() != step:
                return
            if step.part is Part.WHOLE and not self._executor.feed(step.task):
                return
            if self._next_step() == step:
                self._executor.run(step, chart, chosen)

    def _wait(self) -> None:
        """Wait for a command, an answer, other cells, or the end of a question's time."""
        before = self.state
        limit_s = _OTHERS_S if before.in_stage(Stage.ELSEWHERE) else _CHECK_S
        self._loop.run_until(lambda: self.state is not before, limit_s)
        if self.state is before:
            self._judge.escalate()
            self._leases.check_others()

    # --- what happens meanwhile

    def _tick(self) -> None:
        with suppress(LostError):
            self._record.catch_up()
        self._leases.check()
        self._gates.update()
        self._control.check()

    def _on_state(self) -> None:
        self._gates.update()
        self._on_change()

    def _describe(self, text: str) -> None:
        self._doing = text
        self._on_change()

    def _recover(self, because: str, *, is_interrupted: bool = True) -> None:
        """Wait for what was lost, and stop what runs; its progress is unverified."""
        self._panel.forget()
        limit_s = self.work.reconnect_s
        if self._reconnection.recover(because, limit_s, is_interrupted=is_interrupted):
            self._control.note_behavior_end()
