"""The abilities of all packages."""

from __future__ import annotations

from remodel_production.core.ability import Ability, AbilityParameter
from remodel_production.errors import PlannerError
from remodel_states.core.table_error import TableError
from remodel_states.edge import exported_tables


def read_abilities() -> tuple[Ability, ...]:
    """Return the abilities of the tables that packages export, by name.

    Raises:
        PlannerError: if a table cannot be read.
    """
    try:
        rows = exported_tables.read_abilities()
    except TableError as error:
        raise PlannerError(str(error)) from error
    return tuple(
        Ability(
            name,
            row.action.title,
            tuple(AbilityParameter(f.name, f.type, f.text) for f in row.action.goal),
        )
        for name, row in sorted(rows.items())
    )
