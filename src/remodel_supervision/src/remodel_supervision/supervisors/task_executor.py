"""Has the cell do what a step of a run asks for: build the panel, run a behavior, or inspect."""

from __future__ import annotations

from collections.abc import Callable

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_states.core.codes import Code
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Chosen,
    FeedRefused,
    OperationEnded,
    PanelLoaded,
    Part,
    PartRequested,
    Settled,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.gate import FEEDER, cut_short_event, is_cut_short
from remodel_supervision.core.runs.state import FINISHED, PREEMPTED
from remodel_supervision.core.runs.step import Execute, Settle
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.errors import HaltedError, LeavingError, RefusedError
from remodel_supervision.supervisors.gate_keeper import SUPERVISOR, GateKeeper
from remodel_supervision.supervisors.ports import (
    Cell,
    EventLoop,
    Inspection,
    Peers,
    UnseenError,
    Work,
)
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_tasks.core.problem.problem import End


class PanelLoader:
    """Loads the panel of one run."""

    def __init__(self, record: RunRecord, work: Work, cell: Cell, gates: GateKeeper) -> None:
        """Begin without a panel.

        Args:
            record: of the run.
            work: what the run is about.
            cell: that builds the panel.
            gates: let it be built.
        """
        self._record = record
        self._work = work
        self._cell = cell
        self._gates = gates
        # Where the cell answered that has the panel; another address is another process.
        self._loaded_at = ""

    def load(self) -> None:
        """Have the cell build the panel, unless this cell process has it.

        Raises:
            RefusedError: if the cell cannot build it, or cannot do what the order asks for.
        """
        if self._work.panel is None or self._cell.address() == self._loaded_at:
            return
        state = self._record.state
        # A cell that began later may have built it first, and placed wires on it.
        keep = state.keep_panel or self._record.insist(self._work.leases.begun_elsewhere)
        self._gates.enter(SUPERVISOR, "loading the panel")
        try:
            self._cell.load(
                self._work.panel,
                state.serial,
                self._record.owner,
                demands=self._work.planner.demands,
                keep=keep,
            )
        except RefusedError as error:
            raise RefusedError(error.code, f"{error}{_remedy(error, state.use_case)}") from error
        finally:
            self._gates.gate.end(SUPERVISOR)
        self._record.append(PanelLoaded(state.serial))
        self._loaded_at = self._cell.address()

    def forget(self) -> None:
        """Assume that no cell has the panel: the one that had it may have been lost."""
        self._loaded_at = ""


def _remedy(error: RefusedError, use_case: str) -> str:
    """Return what a person can do about a panel that does not fit the cell."""
    if error.code != Code.INVALID_GOAL:
        return ""
    return (
        f"\nNothing has moved. Correct the design or use case {use_case}, or choose another cell "
        "or use case (remodel run --use-case)."
    )


class TaskInspector:
    """Inspects tasks whose progress is unverified, and records what is connected."""

    def __init__(
        self,
        record: RunRecord,
        planner: WorkPlanner,
        inspection: Inspection,
        gates: GateKeeper,
    ) -> None:
        """Take the run's record, and what inspects.

        Args:
            record: of the run.
            planner: of its order.
            inspection: the ability.
            gates: let it move.
        """
        self._record = record
        self._planner = planner
        self._inspection = inspection
        self._gates = gates

    def inspect(self, name: str) -> None:
        """Inspect a task, and record which of its ends are connected, or why that is not visible.

        Raises:
            HaltedError: if the gate is closed.
            LostError: if the ability is lost; it counts as moving until everything is stopped.
        """
        self._gates.update()
        gate = self._gates.gate
        decisions = self._record.state.tasks[name].decisions
        planned = self._planner.task(name, decisions)
        connected: list[str] = []
        self._gates.enter(SUPERVISOR, f"inspecting {name}")
        try:
            for end in End:
                terminal = planned.decomposition.task.terminals[end]
                component = planned.component_of[terminal]
                if self._is_connected(name, end, component, terminal):
                    connected.append(end.letter)
            gate.end(SUPERVISOR)
        except HaltedError:
            gate.end(SUPERVISOR)
            raise
        except UnseenError as error:
            gate.end(SUPERVISOR)
            if gate.halt:
                raise HaltedError(gate.halt) from error
            self._keep(Settled(name, tuple(connected), 1, error.code, unseen=str(error)))
            self._gates.tasks.note_stop(error.goal_id)
            return
        left = self._planner.task(name, decisions, connected).left(connected)
        self._keep(Settled(name, tuple(connected), len(left)))

    def _is_connected(self, name: str, end: End, component: str, terminal: str) -> bool:
        if self._gates.gate.halt:
            raise HaltedError(self._gates.gate.halt)
        return self._inspection.is_connected(
            self._record.owner,
            name,
            end.letter,
            component,
            terminal=terminal.removeprefix(f"{component}:"),
        )

    def _keep(self, settled: Settled) -> None:
        self._record.append_if_next(Settle(settled.task), settled, while_paused=True)


class TaskExecutor:
    """Executes tasks, one behavior at a time."""

    def __init__(
        self,
        record: RunRecord,
        loop: EventLoop,
        work: Work,
        peers: Peers,
        gates: GateKeeper,
        on_behavior_end: Callable[[], None],
    ) -> None:
        """Take the run's record, and what executes its tasks.

        Args:
            record: of the run.
            loop: time.
            work: what the run is about.
            peers: processes that it needs.
            gates: run behaviors, and let the feeder move.
            on_behavior_end: called when a behavior has ended, before that is recorded.
        """
        self._record = record
        self._loop = loop
        self._work = work
        self._peers = peers
        self._gates = gates
        self._on_behavior_end = on_behavior_end

    def chart(self, step: Execute) -> tuple[Chart, tuple[Chosen, ...]]:
        """Return the chart of a behavior, and the parameters of it that learning chose."""
        planner, task = self._work.planner, self._record.state.tasks[step.task]
        chosen: tuple[Chosen, ...] = ()
        if step.part.is_attempt:
            seed = f"run {self._record.run}, {task.name}, attempt {task.attempts + 1}"
            chosen = planner.choose(task.name, task.decisions, seed)
        chart = planner.chart(task.name, step.part, task.connected, task.decisions, chosen=chosen)
        return chart, chosen

    def feed(self, name: str) -> bool:
        """Have a piece of a task's wire presented; return whether it is there."""
        self._record.append_if_next(Execute(name, Part.WHOLE), PartRequested(name))
        self._gates.enter(FEEDER, f"feeding {name}")
        gate = self._gates.gate
        try:
            self._peers.cell.feed(name, self._record.owner)
        except RefusedError as error:
            gate.end(FEEDER)
            self._record.append(FeedRefused(name, error.code, str(error), self._loop.now_s()))
            return False
        except LeavingError:
            raise  # the feeder goes on
        except BaseException:
            gate.end(FEEDER)
            raise
        gate.end(FEEDER)
        return True

    def run(self, step: Execute, chart: Chart, chosen: tuple[Chosen, ...]) -> None:
        """Run a behavior to its end, and record what it does, and how it ended."""
        name, part = step.task, step.part
        attempt = self._record.state.tasks[name].attempts + part.is_attempt
        begun_s = self._loop.now_s()
        xml = write_chart(chart)
        begun = TaskBegun(name, attempt, part, chart.name, chart=xml, at_s=begun_s, chosen=chosen)
        self._record.append_if_next(step, begun)
        self._gates.update()
        self._peers.pictures.begin()
        outcome = self._gates.tasks.run(chart.name, lambda operation: self._keep(name, operation))
        self._on_behavior_end()
        halted, now = self._gates.tasks.halted, self._gates.circumstances
        if outcome == PREEMPTED and is_cut_short(self._record.state, name, halted, now):
            self._record.append(cut_short_event(name, halted, now))
            return
        pictures = self._peers.pictures.keep(self._record.run, f"{name}-{attempt}-{part.value}")
        truth = self._peers.cell.placed(name)
        is_done = part.is_attempt and outcome == FINISHED
        path = self._peers.engine.path()
        at_s = self._loop.now_s()
        ended = TaskEnded(
            name,
            outcome,
            at_s,
            placed=is_done if truth is None else truth,
            path=path,
            pictures=pictures,
            denied=truth is False,
        )
        self._record.append(ended)

    def _keep(self, name: str, operation: Operation) -> None:
        self._record.catch_up()
        kept = self._record.state.tasks[name].operations
        if operation.goal_id in [each.goal_id for each in kept]:
            return  # the answer to its commit was lost
        self._record.append_now(OperationEnded(name, operation))
        self._work.planner.learn(name, operation)
