"""Describe how tasks decompose, and what was rejected."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from remodel_tasks.core.decomposition.decomposed import Decomposition
from remodel_tasks.core.orders.work_order import WorkOrder


def outline_of_order(order: WorkOrder, plans: Sequence[Decomposition]) -> Iterator[str]:
    """Yield the tasks of an order, a cable as one task whose cores are its steps, line by line."""
    plan_of = {plan.task.name: plan for plan in plans}
    for task in order.whole_tasks:
        cores = [plan_of[wire] for wire in task.wires]
        if not task.is_cable:
            yield from outline(*cores)
            continue
        seconds = sum(core.duration_s for core in cores)
        yield f"{task.name}: cable of {len(cores)} cores, {seconds:.1f} s of work, one task"
        for core in cores:
            yield from (f"  {line}" for line in outline(core))


def outline(decomposition: Decomposition) -> Iterator[str]:
    """Yield a task as a tree of methods and actions, line by line."""
    task = decomposition.task
    success = 1.0
    for step in decomposition.steps:
        success *= step.expected.success
    seconds = sum(step.expected.duration_s for step in decomposition.steps)
    yield (
        f"{task.name}: {' to '.join(task.terminals)}, {seconds:.1f} s of work, succeeds in "
        f"{100 * success:.0f} % of cases"
    )
    shown: tuple[tuple[str, str], ...] = ()
    end = None
    for step in decomposition.steps:
        if step.end is not end:
            shown, end = (), step.end
        for depth, (name, method) in enumerate(step.methods):
            if step.methods[: depth + 1] != shown[: depth + 1]:
                yield f"{'  ' * (depth + 1)}{name}: {method}"
        shown = step.methods
        yield (
            f"{'  ' * (len(step.methods) + 1)}{step.title} ({', '.join(step.action.abilities)}), "
            f"{step.expected.duration_s:.1f} s"
        )
    for rejected in decomposition.rejected:
        yield f"  rejected: {rejected.task}: {rejected.method}: {rejected.reason}"
