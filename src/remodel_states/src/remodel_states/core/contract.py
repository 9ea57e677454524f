"""What the contract of all abilities fixes: times, owners of goals, robots, and a cell's limits."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from remodel_states.core.table_error import TableError

# The times of the contract between ability servers and their clients (remodel_msgs/README.md)


# [s] ROS time that a server has beyond a goal's timeout to report its end.
GRACE_S = 2.0

# [s] Wall time from a cancel to the goal's end.
CANCEL_LIMIT_S = 0.5

# [s] ROS time; a goal that takes longer reports its progress before it ends.
SILENT_LIMIT_S = 1.0

# [s] ROS time after which the client of a goal that was not taken has given up on the server.
LATE_S = 5.0

# [s] By which the clocks of a cell's machines may differ.
CLOCKS_DIFFER_S = 1.0


# Which supervisor sent a goal: its token is in front of the goal's id, "17:Connect/Insert#1"


NO_OWNER = 0
# A token is a uint64: 20 digits at most.
_PREFIX = re.compile(r"([0-9]{1,20}):")


def owner_of(goal_id: str) -> int:
    """Return the token in front of a goal's id, NO_OWNER if there is none."""
    prefix = _PREFIX.match(goal_id)
    return int(prefix[1]) if prefix else NO_OWNER


# The fields of goals, which are parameters of states too, that name the robots that do them


# An ability that takes two robots is given them in this order.
ROBOT_FIELDS = ("robot_name", "guide_name", "robot_1_name", "robot_2_name")


# The limits of a cell, which no goal exceeds, whatever charts and use cases state.
#
#     force_limit: 25.0               # of every ability
#     speed_m_s: 0.25
#     InsertCable: {force_limit: 20.0}
#
# A name is a field of goals, or what a server itself reads of `AbilityServer.limits`.


SOURCE = "parameter /remodel/limits"


def limits_of(ability: str, document: object) -> dict[str, float]:
    """Return the limits of one ability by name: its own, or that of every ability if it is lower.

    Raises:
        TableError: if the document is no table of limits, with the place and what is needed.
    """
    if not isinstance(document, Mapping):
        raise TableError(SOURCE, [f"{document!r} found; needed: {{NAME: NUMBER}}"])
    own = document.get(ability, {})
    if not isinstance(own, Mapping):
        raise TableError(SOURCE, [f"{ability}: {own!r} found; needed: {{NAME: NUMBER}}"])
    general = {name: value for name, value in document.items() if not isinstance(value, Mapping)}
    found: dict[str, float] = {}
    for where, name, value in (
        *((name, name, value) for name, value in general.items()),
        *((f"{ability}.{name}", name, value) for name, value in own.items()),
    ):
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not 0 < value < math.inf:
            raise TableError(SOURCE, [f"{where}: {value!r} found; needed: a number above 0"])
        found[name] = min(float(value), found.get(name, math.inf))
    return found


def beyond_limit(goal: object, limits: Mapping[str, float]) -> str:
    """Return which field of a goal exceeds its limit, with both values; empty if none does."""
    for name, limit in limits.items():
        value = getattr(goal, name, 0.0)
        if isinstance(value, int | float) and abs(value) > limit:
            return f"{name} is {value:g}, at most {limit:g} is allowed in this cell ({SOURCE})"
    return ""
