"""Which tasks of an order a robot does, and which are left to a person, with the reason.

A task is by hand if its use case does not allow one of its characteristics, or if no method does
it. The others are planned as if the task were not there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from remodel_planning.core.condition import Value
from remodel_planning.core.decomposition.decomposition import Decomposer
from remodel_planning.core.decomposition.wiring_problem import decompose_task, decomposer_of
from remodel_planning.core.orders.work_order import ByHand, Task, WorkOrder
from remodel_planning.core.use_case.model import UseCase
from remodel_production.errors import InstanceError


def triaged(order: WorkOrder, use_case: UseCase) -> WorkOrder:
    """Return an order with the tasks that a robot can do, and the others by hand.

    Raises:
        InstanceError: if a robot can do none of them, with the reason for the first.
    """
    decomposer = decomposer_of(order, use_case)
    reasons = {task.name: _reason(task, decomposer) for task in order.tasks}
    by_hand = tuple(ByHand(name, why) for name, why in reasons.items() if why)
    if not by_hand:
        return order
    if len(by_hand) == len(order.tasks):
        raise InstanceError(
            f"no task is for the robot: all {len(by_hand)} are by hand, such as {by_hand[0]}"
        )
    done = {task for task, why in reasons.items() if not why}
    return replace(
        order,
        tasks=tuple(task for task in order.tasks if task.name in done),
        unders=tuple(under for under in order.unders if {under.before, under.after} <= done),
        soft_constraints=tuple(s for s in order.soft_constraints if {s.before, s.after} <= done),
        by_hand=(*order.by_hand, *by_hand),
    )


def _reason(task: Task, decomposer: Decomposer) -> str:
    """Return why a task is by hand; empty if a robot can do it."""
    refused = _refused_characteristic(task.characteristics, decomposer.use_case)
    if refused:
        return refused
    try:
        decompose_task(task, decomposer)
    except InstanceError as error:
        return str(error).removeprefix(f"task {task.name}: ")
    return ""


def _refused_characteristic(stated: Mapping[str, Value], use_case: UseCase) -> str:
    for name, value in stated.items():
        characteristic = use_case.task_characteristics.get(name)
        wrong = characteristic.objection(value) if characteristic else ""
        if wrong:
            return (
                f"{name} is {value}, and must be {wrong} (characteristics.task.{name} of use case "
                f"{use_case.name})"
            )
    return ""
