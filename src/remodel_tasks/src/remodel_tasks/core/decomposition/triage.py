"""Which tasks of an order a robot does, by which method, and which are left to a person.

A task is by hand if the design leaves it no place, if its use case does not allow one of its
characteristics, or if no method does it. The others are planned as if the task were not there. Of
those, the tasks are noted that are done by another method than the preferred one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from remodel_production.errors import InstanceError
from remodel_run.findings import ByHand, OtherMethod
from remodel_run.whole_task import whole_tasks
from remodel_tasks.core.condition import Features, Value
from remodel_tasks.core.decomposition.decomposed import Decomposition
from remodel_tasks.core.decomposition.wiring_problem import decompose_task, decomposer_of
from remodel_tasks.core.orders.work_order import Refusal, WorkOrder
from remodel_tasks.core.use_case.model import INSERTED, Method, UseCase


def triaged(
    order: WorkOrder, use_case: UseCase, refused: Mapping[str, Refusal] = MappingProxyType({})
) -> WorkOrder:
    """Return an order with the tasks that a robot can do, maybe none, and the others by hand.

    Args:
        order: all tasks.
        use_case: by which they are done.
        refused: tasks that are by hand for reasons of the cell, by name.
    """
    decomposer = decomposer_of(order, use_case)
    others: dict[str, OtherMethod] = {}
    refusals: dict[str, Refusal] = {}
    whole = {wire: task.name for task in order.whole_tasks for wire in task.wires}
    for task in order.tasks:
        why = (
            task.by_hand
            or _refused_characteristic(task.characteristics, use_case)
            or refused.get(task.name)
        )
        plan = None
        if why is None:
            try:
                plan = decompose_task(task, decomposer)
            except InstanceError as error:
                why = Refusal("", str(error).removeprefix(f"task {task.name}: "))
        if why is not None:
            refusals[task.name] = why
        elif plan is not None:
            _note_methods(others, whole[task.name], plan.alone, use_case)
    return replace(
        order.with_tasks([task for task in order.tasks if task.name not in refusals]),
        by_hand=(*order.by_hand, *_by_hand(order, refusals)),
        other_methods=tuple(others.values()),
    )


def _by_hand(order: WorkOrder, refusals: Mapping[str, Refusal]) -> Iterator[ByHand]:
    """Yield the tasks that are refused, with the reasons; of a cable all cores that are."""
    refused = ((task.name, task.cable) for task in order.tasks if task.name in refusals)
    for name, wires in whole_tasks(refused):
        reasons = dict.fromkeys(refusals[wire].reason for wire in wires)
        yield ByHand(name, wires, "; ".join(reasons), refusals[wires[0]].kind)


def _note_methods(
    others: dict[str, OtherMethod], task: str, decomposition: Decomposition, use_case: UseCase
) -> None:
    """Add a task to the methods that it is done by, as far as they are not the preferred ones."""
    rejected = {(each.task, each.method): each.reason for each in decomposition.rejected}
    taken = {
        (pair, step.features.get(INSERTED)): step.features
        for step in decomposition.steps
        for pair in step.methods
    }
    for ((name, method), _), features in taken.items():
        preferred = _preferred(use_case.methods[name], features)
        if method != preferred:
            why = rejected.get((name, preferred))
            reason = f"{preferred}: {why}" if why else f"{preferred} at one of its ends"
            key = f"methods.{name}.{method} in {use_case.file_name}"
            known = others.get(key, OtherMethod(key, (), reason))
            if task not in known.tasks[-1:]:  # another core of the same cable
                others[key] = replace(known, tasks=(*known.tasks, task))


def _preferred(methods: Sequence[Method], features: Features) -> str:
    """Return the name of the first method for this end, be it the first one or the second one."""
    return next(
        method.name
        for method in methods
        if all(test.passes(features) for test in method.when.tests if test.name == INSERTED)
    )


def _refused_characteristic(stated: Mapping[str, Value], use_case: UseCase) -> Refusal | None:
    for name, value in stated.items():
        characteristic = use_case.task_characteristics.get(name)
        wrong = characteristic.objection(value) if characteristic else ""
        if characteristic and wrong:
            return Refusal(
                f"whose {name} is {characteristic.excess(value) or f'not {wrong}'}",
                f"{name} is {value}, and must be {wrong} (characteristics.task.{name} in "
                f"{use_case.file_name})",
            )
    return None
