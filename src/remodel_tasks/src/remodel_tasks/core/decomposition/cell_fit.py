"""What of a board a cell can wire: which tasks are by hand, and why the board does not fit."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping

from remodel_production.core.board.panel import Panel, PanelWire
from remodel_production.errors import OrderError
from remodel_run.whole_task import counted
from remodel_states.core.cell import CellLimits, Passage, footprint, objections, overlaps
from remodel_states.core.wires.wire_colours import WIRE_RGB, is_colour
from remodel_tasks.core.decomposition.triage import triaged
from remodel_tasks.core.orders.work_order import Refusal, WorkOrder
from remodel_tasks.core.use_case.designs import DesignTasks
from remodel_tasks.core.use_case.model import UseCase

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
    if takes is not None and _has_wires(use_case):
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


def _has_wires(use_case: UseCase) -> bool:
    return use_case.designs is not None and use_case.designs.tasks is DesignTasks.WIRES


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
