"""Who may command the cell.

A supervisor that acquires the cell gets a token greater than all before. It puts the token in
front of the id of each goal ("17:insert a") and into the requests of services. The cell refuses a
token older than the newest it has seen, so a supervisor that lost the cell while it was stopped
moves nothing when it continues. A goal without a token is not checked.
"""

from __future__ import annotations

from remodel_states.core.codes import Code
from remodel_states.core.goal_owner import NO_OWNER
from remodel_work.errors import AbilityError


def check_owner(owner: int, newest: int) -> None:
    """Raise STALE_OWNER when a token is older than the newest that the cell has seen."""
    if owner != NO_OWNER and owner < newest:
        raise AbilityError(
            Code.STALE_OWNER,
            f"owner {owner} no longer owns this cell, owner {newest} does; stop the older "
            "supervisor, or reset the cell's memory if the database was replaced",
        )
