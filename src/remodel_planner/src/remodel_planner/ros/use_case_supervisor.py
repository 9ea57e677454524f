"""The use case supervisor: takes planned tasks through chart, behavior, cell and record."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from sensor_msgs.msg import Image

from flexbe_synthesizer.core.model import Chart
from remodel_planner.core.panel_layout import CutWire, PanelLayout, PanelRules
from remodel_planner.core.recovery.decide import Decision
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.recovery.history import Recovery
from remodel_planner.core.run import Execution
from remodel_planner.core.use_case.planned_tasks import PlannedTask
from remodel_planner.core.use_case.task_chart import FINISHED, content_mark
from remodel_planner.edge.chart_folder import keep_chart
from remodel_planner.edge.known_behaviors import describes
from remodel_planner.edge.production_database import ProductionDatabase, Run
from remodel_planner.ros.behavior_synthesizer import BehaviorSynthesizer
from remodel_planner.ros.cell import Cell
from remodel_planner.ros.panel_message import panel_message
from remodel_planner.ros.task_supervisor import Sight, TaskSupervisor

# Outcome of a behavior that somebody stopped.
PREEMPTED = "preempted"

# What this supervisor can do about a task that failed; what it can not is passed over.
POSSIBLE = frozenset({Do.NEW_PART, Do.SET_ASIDE, Do.STOP})

# Plans the tasks of these names anew.
Replan = Callable[[Collection[str]], Sequence[PlannedTask]]


@dataclass(frozen=True)
class WireRun:
    """One attempt at a wire's task, ended: its chart, what happened, and what was seen.

    Attributes:
        decision: what is done about it; None if it did not fail.
    """

    cut: CutWire
    chart: Chart
    execution: Execution
    sights: tuple[Sight, ...]
    after: Image
    decision: Decision | None

    @property
    def last(self) -> bool:
        """Whether no other attempt at this wire follows."""
        return self.decision is None or self.decision.do.is_lasting


class UseCaseSupervisor:
    """Runs the tasks of one order, one after another."""

    def __init__(
        self, database: ProductionDatabase, chart_folder: Path, recovery: Recovery, replan: Replan
    ) -> None:
        """Connect to cell, synthesizer and engine.

        Args:
            database: that keeps the records.
            chart_folder: where the task charts are written; one that the synthesizer may read.
            recovery: decides about tasks that fail.
            replan: plans what is left to do.

        Raises:
            CellError: if one of them is not there in time.
        """
        self._database = database
        self._chart_folder = chart_folder
        self._recovery = recovery
        self._replan = replan
        self._cell = Cell()
        self._synthesizer = BehaviorSynthesizer()
        self._tasks = TaskSupervisor()

    def run(
        self, run: Run, layout: PanelLayout, rules: PanelRules, tasks: Sequence[PlannedTask]
    ) -> Iterator[WireRun]:
        """Build the panel, and place its wires one by one, in the order of a plan's tasks.

        What is done about a task that fails, its use case's policy says: it is tried again with a
        new wire, its turn comes when the rest is done in an order planned anew, it is set aside,
        or the run stops. It stops too when somebody stops a behavior.

        Yields:
            Each attempt when it has ended and is recorded.

        Raises:
            CellError: if the cell, the synthesizer or the engine refuses or falls silent.
        """
        self._cell.load(panel_message(layout, rules))
        cuts = {cut.wire.name: cut for cut in layout.wires}
        waiting = list(tasks)
        while waiting:
            task, *waiting = waiting
            self._synthesize(task.chart)
            possible = POSSIBLE | {Do.REPLAN} if waiting else POSSIBLE
            do = Do.NEW_PART
            while do is Do.NEW_PART:
                wire_run = self._place(run, cuts[task.name], task.chart, possible)
                yield wire_run
                if wire_run.execution.outcome == PREEMPTED:
                    return
                do = wire_run.decision.do if wire_run.decision else None
            if do is Do.STOP:
                return
            if do is Do.REPLAN:
                waiting = [*self._replan([other.name for other in waiting]), task]

    def overview(self) -> Image:
        """Return a picture of the whole cell."""
        return self._cell.picture("scene")

    def _synthesize(self, chart: Chart) -> None:
        """Have the behavior of a chart made, unless it exists with the same content."""
        chart_file, _ = keep_chart(chart, self._chart_folder)
        if not describes(chart.name, content_mark(chart)):
            self._synthesizer.synthesize(str(chart_file), chart.name)

    def _place(self, run: Run, cut: CutWire, chart: Chart, possible: Collection[Do]) -> WireRun:
        wire = cut.wire.name
        self._cell.feed(wire, cut.channel)
        task = self._tasks.run(chart.name)
        execution = Execution(
            wire,
            chart.name,
            self._recovery.attempts(wire) + 1,
            task.outcome,
            self._cell.placed(wire),
            task.started_s,
            task.ended_s,
            task.operations,
        )
        decision = None
        if task.outcome in (FINISHED, PREEMPTED):
            self._recovery.ended(execution)
        else:
            decision = self._recovery.decide(execution, possible)
        self._database.add_execution(run, execution, decision)
        after = self._cell.picture("scene")
        return WireRun(cut, chart, execution, task.sights, after, decision)
