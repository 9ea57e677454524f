"""What the cell of a use case can wire, by the cell's file."""

from __future__ import annotations

from contextlib import suppress

from remodel_production.errors import InstanceError
from remodel_states.core.cell import CellLimits
from remodel_states.core.tables import TableError
from remodel_states.edge.exported_tables import cell_names, read_cell_limits
from remodel_tasks.core.use_case.model import UseCase


def cell_takes(use_case: UseCase, cell: str = "") -> CellLimits | None:
    """Return what a cell takes; None if it is not known.

    Args:
        use_case: whose cell it is if no other one is named.
        cell: name of a cell, or its file; empty: that of the use case, if it is known here.

    Raises:
        InstanceError: if there is no such cell, or its file does not say what it takes.
    """
    named = cell or (use_case.designs.cell if use_case.designs is not None else "")
    if not named or (not cell and named not in cell_names()):
        return None
    return named_cell(named)


def known_cells() -> tuple[CellLimits, ...]:
    """Return what each cell of the packages takes, without those whose files are wrong."""
    found = []
    for name in cell_names():
        with suppress(TableError):
            found.append(read_cell_limits(name))
    return tuple(found)


def named_cell(cell: str) -> CellLimits:
    """Return what a cell takes, by its name or file.

    Raises:
        InstanceError: if there is no such cell, or its file does not say what it takes.
    """
    try:
        return read_cell_limits(cell)
    except TableError as error:
        raise InstanceError(f"cell {error}") from error
