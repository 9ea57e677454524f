"""Read the table of faults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from remodel_planner.core.recovery.fault import Do, Fault, FaultTable, Level, Severity
from remodel_planner.core.recovery.policy import response_from
from remodel_planner.errors import PlannerError
from remodel_states.edge.exported_tables import read_faults as read_fault_tables
from remodel_states.errors import TableError


def read_faults() -> FaultTable:
    """Return the faults of all packages.

    Raises:
        PlannerError: if a table cannot be read.
    """
    try:
        tables = read_fault_tables()
    except TableError as error:
        raise PlannerError(str(error)) from error
    return FaultTable([_fault(row, tables.numbers) for row in tables.faults.values()])


def _fault(row: Mapping[str, Any], codes: Mapping[str, int]) -> Fault:
    return Fault(
        row["fault"],
        row["family"],
        frozenset(codes[name] for name in row["codes"]),
        row.get("after", {}).get("times", 1),
        Severity(row["severity"]),
        row["symptoms"],
        Level(row["first_level"]),
        tuple(response_from(response) for response in row["responses"]),
        row.get("unattended") == Do.STOP.value,
    )
