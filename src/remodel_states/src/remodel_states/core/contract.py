"""What the contract of all abilities fixes: times, owners of goals, robots, and a cell's limits."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Mapping

from remodel_states.core.tables import TableError

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
        if not is_number or not 0 < value <= sys.float_info.max:
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


# The time that a goal takes: the clock of a simulation may be set back, or far ahead, when the
# simulation restarts. Such a jump is not time that an ability had. So the deltas between two
# readings are added up, without those that no simulation can produce in the wall time between them.


# A simulation runs this much faster than the wall clock at most.
_MAX_SPEED = 100.0

# [s] Wall time between two readings that is taken into account. A clock that was stopped for long
# and then jumps must not pass for a fast simulation; states read it at 10 Hz or faster.
_MAX_WALL_S = 0.25

# [s] ROS time of one step of `/clock`, at most: it may arrive right after a reading.
_MAX_STEP_S = 1.0


class RosStopwatch:
    """Adds up the ROS time that passes between its readings."""

    def __init__(self, ros_now: Callable[[], float], wall_now: Callable[[], float]) -> None:
        """Start.

        Args:
            ros_now: returns the ROS time [s].
            wall_now: returns a monotonic wall time [s].
        """
        self._ros_now, self._wall_now = ros_now, wall_now
        self._ros_s, self._wall_s = ros_now(), wall_now()
        self._elapsed_s = 0.0

    def read(self) -> float:
        """Return the ROS time [s] that has passed, without jumps."""
        ros_s, wall_s = self._ros_now(), self._wall_now()
        delta_s = ros_s - self._ros_s
        if delta_s == 0.0:
            return self._elapsed_s  # a clock between two steps; the next one may be a large one
        wall_delta_s = min(wall_s - self._wall_s, _MAX_WALL_S)
        if 0.0 < delta_s <= _MAX_SPEED * wall_delta_s + _MAX_STEP_S:
            self._elapsed_s += delta_s
        self._ros_s, self._wall_s = ros_s, wall_s
        return self._elapsed_s
