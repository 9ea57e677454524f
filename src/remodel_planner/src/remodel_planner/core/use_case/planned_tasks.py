"""The tasks of a plan in their order, each decomposed as the plan does it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flexbe_synthesizer.core.model import Chart
from remodel_planner.core.planning.listing import listing_of
from remodel_planner.core.planning.problem import Plan
from remodel_planner.core.use_case.decomposed import Decomposition
from remodel_planner.core.use_case.preparation import Prepared
from remodel_planner.core.use_case.task_chart import task_chart
from remodel_planner.core.use_case.wiring_problem import decomposer_of


@dataclass(frozen=True)
class PlannedTask:
    """A task as a plan does it.

    Attributes:
        arms: the one that begins, and the one that it hands over to, if it does.
    """

    decomposition: Decomposition
    arms: tuple[str, ...]
    chart: Chart

    @property
    def name(self) -> str:
        """The task's name."""
        return self.decomposition.task.name


def planned_tasks(prepared: Prepared, plan: Plan) -> Iterator[PlannedTask]:
    """Yield the tasks of a valid plan, in the order in which they are begun."""
    order = prepared.order
    decomposer = decomposer_of(order, prepared.use_case, prepared.expectations)
    component_of = {terminal.name: terminal.component for terminal in order.terminals}
    task = {task.name: task for task in order.tasks}
    names = [arm.name for arm in order.arms]
    listing = listing_of(prepared.preferred.problem, plan)
    for name in listing.wires:
        mode = listing.modes[name]
        decomposition = decomposer.decompose(
            task[name], mode.first, prepared.limits, hands_over=mode.hands_over
        )
        arms = names[mode.arm : mode.arm + 1]
        if mode.hands_over:
            arms.append(names[1 - mode.arm])
        chart = task_chart(prepared.use_case, decomposition, component_of, tuple(arms))
        yield PlannedTask(decomposition, tuple(arms), chart)
