"""Which supervisor may command a cell: the one with the newest token.

A token is a number that grows whenever a supervisor takes a cell over. It is in front of a goal's
id, such as "17:Connect/Insert#1", and a field of the cell's services. Who shows no token is not
checked.
"""

from __future__ import annotations

from collections.abc import Mapping

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError


def admitted(owners: Mapping[str, int], cell: str, token: int) -> dict[str, int]:
    """Return the newest token of each cell, after one was shown to a cell.

    Raises:
        AbilityError: STALE_OWNER if the cell has seen a newer one.
    """
    newest = owners.get(cell, 0)
    if 0 < token < newest:
        raise AbilityError(
            ErrorCode.STALE_OWNER,
            f"supervisor {token} no longer owns {cell}: supervisor {newest} does. Stop the older "
            "one, or give each cell a name of its own",
        )
    return {**owners, cell: token} if token > newest else dict(owners)
