"""Goals to try an ability server with: a good one, and bad ones made from it."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from genpy import Message

# Stands for a name that does not exist.
UNKNOWN_NAME = "no_such_name"

_FLOATS = frozenset({"float32", "float64"})


@dataclass(frozen=True)
class BadGoal:
    """A goal that is invalid in one field.

    Attributes:
        field: the field, as it stands in the goal.
        what: what is wrong with it, in words.
        goal: the goal.
    """

    field: str
    what: str
    goal: Any


def invalid_goals(good: Message) -> Iterator[BadGoal]:
    """Yield goals that a server must refuse before anything moves."""
    for value in (0.0, -1.0, math.inf, math.nan):
        yield BadGoal("timeout", f"timeout {value}", _with(good, "timeout", value))
    yield BadGoal("id", "an empty id", _with(good, "id", ""))
    for name, kind in zip(good.__slots__, good._slot_types, strict=True):
        if name == "timeout":
            continue
        spoilt = copy.deepcopy(good)
        if kind in _FLOATS:
            setattr(spoilt, name, math.nan)
            yield BadGoal(name, f"{name} NaN", spoilt)
        elif _spoil(getattr(spoilt, name)):
            yield BadGoal(name, f"{name} with NaN", spoilt)


def goals_with_unknown_names(good: Message) -> Iterator[BadGoal]:
    """Yield goals about things that do not exist: whatever a server does, they cannot succeed."""
    for name in _names(good):
        if getattr(good, name):
            yield BadGoal(name, f"{name} {UNKNOWN_NAME!r}", _with(good, name, UNKNOWN_NAME))


def names_left_empty(good: Message) -> list[str]:
    """Return the fields of names that are empty in a goal, so that no other name is tried."""
    return [name for name in _names(good) if not getattr(good, name)]


def _names(goal: Message) -> list[str]:
    kinds = zip(goal.__slots__, goal._slot_types, strict=True)
    return [name for name, kind in kinds if kind == "string" and name != "id"]


def _with(good: Message, name: str, value: object) -> Message:
    goal = copy.deepcopy(good)
    setattr(goal, name, value)
    return goal


def _spoil(value: object) -> bool:
    """Make every number inside a message NaN; return whether there was one."""
    if isinstance(value, list):
        return any([_spoil(item) for item in value])
    if not isinstance(value, Message):
        return False
    found = False
    for name, kind in zip(value.__slots__, value._slot_types, strict=True):
        if kind in _FLOATS:
            setattr(value, name, math.nan)
            found = True
        else:
            found = _spoil(getattr(value, name)) or found
    return found
