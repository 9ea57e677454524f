"""Read the table of faults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexbe_synthesizer.core.chart.error_routes import ListedCode, error_names
from remodel_production.errors import PlannerError
from remodel_states.core.tables import FaultTables, TableError
from remodel_states.edge.exported_tables import read_faults as read_fault_tables
from remodel_tasks.core.use_case.fault import Do, Fault, FaultTable, response_from


def read_faults() -> FaultTable:
    """Return the faults of all packages; PlannerError if a table cannot be read."""
    tables = _tables()
    return FaultTable([_fault(row, tables.numbers) for row in tables.faults.values()])


def read_error_names() -> Mapping[str, tuple[int, ...]]:
    """Return the error codes of all packages by the names that charts use: codes and classes.

    Raises:
        PlannerError: if a table cannot be read.
    """
    tables = _tables()
    return error_names(
        ListedCode(name, tables.numbers[name], row["severity"], row["first_level"])
        for row in tables.faults.values()
        if "after" not in row
        for name in row["codes"]
    )


def _tables() -> FaultTables:
    try:
        return read_fault_tables()
    except TableError as error:
        raise PlannerError(str(error)) from error


def _fault(row: Mapping[str, Any], codes: Mapping[str, int]) -> Fault:
    return Fault(
        row["fault"],
        frozenset(codes[name] for name in row["codes"]),
        row.get("after", {}).get("times", 1),
        row["symptoms"],
        responses=tuple(response_from(response) for response in row["responses"]),
        is_geometry=row.get("repeats") == "geometry",
        stops_unattended=row.get("unattended") == Do.STOP.value,
    )
