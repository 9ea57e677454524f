"""The limits of a cell, which no goal exceeds, whatever charts and use cases state.

    force_limit: 25.0               # of every ability
    speed_m_s: 0.25
    InsertCable: {force_limit: 20.0}

A name is a field of goals, or what a server itself reads of `AbilityServer.limits`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from remodel_states.core.table_error import TableError

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
