"""A panel as a cell holds it, and why a cell cannot hold one."""

from __future__ import annotations

from dataclasses import replace

from remodel_work.cell.cell_design import CellDesign
from remodel_work.cell.magazine import find_wire_problems
from remodel_work.layout import find_problems
from remodel_work.panel import Panel


def held_panel(design: CellDesign, panel: Panel) -> Panel:
    """Return a panel where a cell holds it, with the cell's own fixtures."""
    return replace(
        panel,
        clips=(*panel.clips, *design.clips),
        ducts=(*panel.ducts, *design.ducts),
        world_from_panel=design.world_from_panel,
    )


def find_panel_problems(design: CellDesign, panel: Panel) -> tuple[str, ...]:
    """Return why a cell cannot hold a panel, one sentence each; none: it can."""
    held = held_panel(design, panel)
    problems = find_problems(
        held,
        design.arms,
        design.takes,
        has_magazine=design.magazine is not None,
        has_labels=design.labels,
    )
    if design.magazine is None or problems:
        return tuple(problems)
    return tuple(find_wire_problems(held))
