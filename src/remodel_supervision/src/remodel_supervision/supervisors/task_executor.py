"""Presents the piece of a task, runs a behavior of it, and records what both did."""

from __future__ import annotations

from collections.abc import Callable

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Chosen,
    FeedRefused,
    OperationEnded,
    Part,
    PartRequested,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.gate import FEEDER, cut_short_event, is_cut_short
from remodel_supervision.core.runs.state import FINISHED, PREEMPTED
from remodel_supervision.core.runs.step import Execute
from remodel_supervision.errors import LeavingError, RefusedError
from remodel_supervision.supervisors.gate_keeper import GateKeeper
from remodel_supervision.supervisors.ports import EventLoop, Peers, Work
from remodel_supervision.supervisors.run_record import RunRecord


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
