"""What a cell can wire of a board, which tasks of an order a robot does, and which a person.

A task is by hand if the design leaves it no place, if its use case does not allow one of its
characteristics, or if no method does it. The others are planned as if the task were not there. Of
those, the tasks are noted that are done by another method than the preferred one.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from remodel_production.core.board.panel import Panel, PanelWire
from remodel_production.errors import InstanceError, OrderError
from remodel_run.findings import ByHand, OtherMethod
from remodel_run.whole_task import counted, whole_tasks
from remodel_states.core.cell import CellLimits, Passage, footprint, objections, overlaps
from remodel_states.core.wires import WIRE_RGB, is_colour
from remodel_tasks.core.condition import Features, Value
from remodel_tasks.core.decomposition.decomposed import Decomposition
from remodel_tasks.core.decomposition.preparation import decompose_task, decomposer_of
from remodel_tasks.core.orders.work_order import Refusal, WorkOrder
from remodel_tasks.core.use_case.model import INSERTED, DesignTasks, Method, UseCase


def triaged(
    order: WorkOrder, use_case: UseCase, refused: Mapping[str, Refusal] = MappingProxyType({})
) -> WorkOrder:
    """Return an order with the tasks that a robot can do, maybe none, and the others by hand."""
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


# Components that overlap; if there are more, all places are wrong.
_MOST_SHOWN = 3


def fitted(
    order: WorkOrder, panel: Panel, use_case: UseCase, takes: CellLimits | None
) -> WorkOrder:
    """Return an order with the tasks that the robots of a cell do, and the others by hand.

    Args:
        order: all tasks of a board.
        panel: of the same board.
        use_case: by which the tasks are done.
        takes: what the cell can wire; None: that is not known, and only the use case decides.
    """
    refusals: dict[str, Refusal] = {}
    designs = use_case.designs
    if takes is not None and designs is not None and designs.tasks is DesignTasks.WIRES:
        ducts = {
            duct.name: Passage(duct.name, duct.length, duct.slot_pitch, duct.slot_width)
            for duct in panel.ducts
        }
        springs_n = {
            (device.name, opening.name): opening.insertion
            for device in panel.devices
            for opening in device.openings
        }
        refusals = {
            task.name: refusal
            for task, wire in zip(order.tasks, panel.wires, strict=True)
            if (refusal := _refusal(wire, ducts, takes) or _too_stiff(wire, springs_n, use_case))
        }
    return triaged(order, use_case, refusals)


def misfits(panel: Panel, takes: CellLimits) -> tuple[str, ...]:
    """Return a sentence for each limit of a cell that a board exceeds, and why none can have it."""
    taken = {d.name: footprint(d.place, d.size[:2], d.yaw) for d in panel.devices}
    overlapping = list(overlaps(taken))
    more = len(overlapping) - _MOST_SHOWN
    return (
        *takes.about_board(panel.size[:2], len(panel.devices)),
        *overlapping[:_MOST_SHOWN],
        *([f"{more} more overlap"] if more > 0 else []),
    )


def other_cell(panel: Panel, cells: Iterable[CellLimits]) -> str:
    """Return advice to use the smallest cell that takes a board with rails; empty: none does."""
    fits = [cell for cell in cells if panel.rails and not misfits(panel, cell)]
    if not fits:
        return ""
    return f"; cell:={min(fits, key=lambda cell: math.prod(cell.plate)).cell} takes it"


def require_fit(panel: Panel, takes: CellLimits | None, cells: Iterable[CellLimits] = ()) -> None:
    """Raise OrderError, which names one of the cells that takes it, if a board does not fit."""
    if takes is not None and (found := misfits(panel, takes)):
        raise OrderError(
            f"order {panel.name}: the board does not fit cell {takes.cell}: {'; '.join(found)}"
            f"{other_cell(panel, cells)}"
        )


def summary(
    order: WorkOrder, panel: Panel, takes: CellLimits, cells: Iterable[CellLimits] = ()
) -> str:
    """Return how many wires of an order the robots of a cell place, and whether the board fits.

    If it does not, one of `cells` that takes it is named.
    """
    robots = counted(len(order.tasks), "wire")
    kinds = Counter[str]()
    for each in order.by_hand:
        kinds[each.kind or "by no method"] += len(each.wires)
    parts = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    text = f"cell {takes.cell}: {robots} for robots, {len(order.wires_by_hand)} by hand"
    text += f" ({parts})" if parts else ""
    found = misfits(panel, takes)
    if not found:
        return f"{text}; the board fits"
    return f"{text}; the board does not fit: {'; '.join(found)}{other_cell(panel, cells)}"


def _too_stiff(
    wire: PanelWire, springs_n: Mapping[tuple[str, str], float], use_case: UseCase
) -> Refusal | None:
    """Return why no robot pushes a wire into its spring clamps, if one takes more force."""
    bounds = use_case.learned.get("InsertCable", {}).get("force_limit")
    needed = {end: springs_n.get((end.component, end.terminal), 0.0) for end in (wire.a, wire.b)}
    stiffest = max(needed, key=lambda end: needed[end])
    if bounds is None or needed[stiffest] < bounds.frozen:
        return None
    return Refusal(
        "whose spring clamps are too stiff",
        f"the spring of {stiffest} lets a ferrule in with {needed[stiffest]:g} N, and robots push "
        f"with {bounds.frozen:g} N (learned.InsertCable.force_limit in {use_case.name}.yaml)",
    )


def _refusal(wire: PanelWire, ducts: Mapping[str, Passage], takes: CellLimits) -> Refusal | None:
    """Return why a cell takes no such wire; None if it does."""
    if wire.material is None:
        section = f"{wire.section_mm2:g} mm2"
        return Refusal(f"of {section}", f"no table of materials has wires of {section}")
    if not is_colour(wire.colour):  # a shield, or what a mapping or another importer says
        shown = repr(wire.colour) if wire.colour else "none"
        return Refusal(
            "of no known colour", f"its colour is {shown}; allowed: {' '.join(WIRE_RGB)}"
        )
    passages = [ducts[name] for name in wire.ducts]
    found = [*objections(takes, wire.length, wire.material.diameter, wire.route, passages)]
    if not found:
        return None
    sentences = "; ".join(objection.sentence for objection in found)
    return Refusal(found[0].kind, f"{sentences} (cell {takes.cell})")
