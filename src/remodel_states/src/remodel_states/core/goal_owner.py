"""Which supervisor sent a goal: its token is in front of the goal's id, "17:Connect/Insert#1"."""

from __future__ import annotations

import re

NO_OWNER = 0
# A token is a uint64: 20 digits at most.
_PREFIX = re.compile(r"([0-9]{1,20}):")


def owner_of(goal_id: str) -> int:
    """Return the token in front of a goal's id, NO_OWNER if there is none."""
    prefix = _PREFIX.match(goal_id)
    return int(prefix[1]) if prefix else NO_OWNER
