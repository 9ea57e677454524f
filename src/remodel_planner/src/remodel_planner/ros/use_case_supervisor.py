"""The use case supervisor: takes planned tasks through chart, behavior, cell and record."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from sensor_msgs.msg import Image

from flexbe_synthesizer.core.model import Chart
from remodel_planner.core.panel_layout import CutWire, PanelLayout, PanelRules
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

# A wire whose task failed is taken away and fed anew: what a robot can't put right any more, since
# the end sprang out of reach or out of sight, a fresh wire does.
ATTEMPTS = 3


@dataclass(frozen=True)
class WireRun:
    """One attempt at a wire's task, ended: its chart, what happened, and what was seen.

    Attributes:
        last: whether no other attempt at this wire follows.
    """

    last: bool
    cut: CutWire
    chart: Chart
    execution: Execution
    sights: tuple[Sight, ...]
    after: Image


class UseCaseSupervisor:
    """Runs the tasks of one order, one after another."""

    def __init__(self, database: ProductionDatabase, chart_folder: Path) -> None:
        """Connect to cell, synthesizer and engine.

        Args:
            database: that keeps the records.
            chart_folder: where the task charts are written; one that the synthesizer may read.

        Raises:
            CellError: if one of them is not there in time.
        """
        self._database = database
        self._chart_folder = chart_folder
        self._cell = Cell()
        self._synthesizer = BehaviorSynthesizer()
        self._tasks = TaskSupervisor()

    def run(
        self, run: Run, layout: PanelLayout, rules: PanelRules, tasks: Sequence[PlannedTask]
    ) -> Iterator[WireRun]:
        """Build the panel, and place its wires one by one, in the order of a plan's tasks.

        A task that fails is tried again with a new wire. If the last attempt fails too, the wire
        stays where it is, and the next one is placed.

        Yields:
            Each attempt when it has ended and is recorded.

        Raises:
            CellError: if the cell, the synthesizer or the engine refuses or falls silent.
        """
        self._cell.load(panel_message(layout, rules))
        cuts = {cut.wire.name: cut for cut in layout.wires}
        for task in tasks:
            self._synthesize(task.chart)
            for attempt in range(1, ATTEMPTS + 1):
                wire_run = self._place(run, cuts[task.name], task.chart, attempt)
                yield wire_run
                if wire_run.last:
                    break

    def overview(self) -> Image:
        """Return a picture of the whole cell."""
        return self._cell.picture("scene")

    def _synthesize(self, chart: Chart) -> None:
        """Have the behavior of a chart made, unless it exists with the same content."""
        chart_file, _ = keep_chart(chart, self._chart_folder)
        if not describes(chart.name, content_mark(chart)):
            self._synthesizer.synthesize(str(chart_file), chart.name)

    def _place(self, run: Run, cut: CutWire, chart: Chart, attempt: int) -> WireRun:
        wire = cut.wire.name
        self._cell.feed(wire, cut.channel)
        task = self._tasks.run(chart.name)
        execution = Execution(
            wire,
            chart.name,
            attempt,
            task.outcome,
            self._cell.placed(wire),
            task.started_s,
            task.ended_s,
            task.operations,
        )
        self._database.add_execution(run, execution)
        last = task.outcome == FINISHED or attempt == ATTEMPTS
        after = self._cell.picture("scene")
        return WireRun(last, cut, chart, execution, task.sights, after)
