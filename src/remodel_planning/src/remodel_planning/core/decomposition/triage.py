"""Which tasks of an order a robot does, by which method, and which are left to a person.

A task is by hand if the design leaves it no place, if its use case does not allow one of its
characteristics, or if no method does it. The others are planned as if the task were not there. Of
those, the tasks are noted that are done by another method than the preferred one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from remodel_planning.core.condition import Features, Value
from remodel_planning.core.decomposition.decomposed import Decomposition
from remodel_planning.core.decomposition.wiring_problem import decompose_task, decomposer_of
from remodel_planning.core.orders.work_order import ByHand, OtherMethod, WorkOrder
from remodel_planning.core.use_case.model import INSERTED, Method, UseCase
from remodel_production.core.whole_task import whole_tasks
from remodel_production.errors import InstanceError


def triaged(order: WorkOrder, use_case: UseCase) -> WorkOrder:
    """Return an order with the tasks that a robot can do, maybe none, and the others by hand."""
    decomposer = decomposer_of(order, use_case)
    others: dict[str, OtherMethod] = {}
    refusals: dict[str, str] = {}
    whole = {wire: task.name for task in order.whole_tasks for wire in task.wires}
    for task in order.tasks:
        try:
            refused = task.by_hand or _refused_characteristic(task.characteristics, use_case)
            plan = None if refused else decompose_task(task, decomposer)
        except InstanceError as error:
            plan, refused = None, str(error).removeprefix(f"task {task.name}: ")
        if plan is None:
            refusals[task.name] = refused
        else:
            _note_methods(others, whole[task.name], plan.alone, use_case)
    done = {task.name for task in order.tasks} - refusals.keys()
    return replace(
        order,
        tasks=tuple(task for task in order.tasks if task.name in done),
        unders=tuple(under for under in order.unders if {under.before, under.after} <= done),
        soft_constraints=tuple(s for s in order.soft_constraints if {s.before, s.after} <= done),
        by_hand=(*order.by_hand, *_by_hand(order, refusals)),
        other_methods=tuple(others.values()),
    )


def _by_hand(order: WorkOrder, refusals: Mapping[str, str]) -> Iterator[ByHand]:
    """Yield the tasks that are refused, with the reasons; of a cable all cores that are."""
    refused = ((task.name, task.cable) for task in order.tasks if task.name in refusals)
    for name, wires in whole_tasks(refused):
        yield ByHand(name, wires, "; ".join(dict.fromkeys(refusals[wire] for wire in wires)))


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


def _refused_characteristic(stated: Mapping[str, Value], use_case: UseCase) -> str:
    for name, value in stated.items():
        characteristic = use_case.task_characteristics.get(name)
        wrong = characteristic.objection(value) if characteristic else ""
        if wrong:
            return (
                f"{name} is {value}, and must be {wrong} (characteristics.task.{name} in "
                f"{use_case.file_name})"
            )
    return ""
