"""The messages of an ability's action."""

from __future__ import annotations

from genpy import Message
from roslib.message import get_message_class

from remodel_states.core.ability_tables import Ability
from remodel_states.core.table_error import TableError


def message_class(ability: Ability, part: str) -> type[Message]:
    """Return a class such as InsertCableResult.

    Args:
        ability: whose action it is.
        part: "Action", "Goal", "Result", "Feedback", "ActionGoal" and so on.

    Raises:
        TableError: if the package of the ability is not built or sourced.
    """
    found = get_message_class(f"{ability.package}/{ability.name}{part}")
    if found is None:
        problem = f"{ability.name}: its messages are not built; build and source its workspace"
        raise TableError(ability.package, [problem])
    return found
