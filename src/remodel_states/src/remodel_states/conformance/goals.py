"""Goals to try an ability server with: a good one, and bad ones made from it."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import genpy
import yaml
from genpy import Message
from roslib.message import get_message_class

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


# Read the goal that a server is tried with


# [s] Timeout of a goal that names none.
TIMEOUT_S = 60.0

ID = "conformance"


class GoalError(Exception):
    """The goal cannot be read; the text says where, what was found and what to do."""


def action_class(name: str) -> type[Message]:
    """Return the class of an action.

    Args:
        name: such as `DetectCable` (of remodel_msgs) or `package/Name`, with or without Action.

    Raises:
        GoalError: if there is no such action, or the messages of its package cannot be imported.
    """
    kind = name if "/" in name else f"remodel_msgs/{name}"
    kind = f"{kind.removesuffix('Action')}Action"
    try:
        found = get_message_class(kind)
    except Exception as error:
        raise GoalError(f"cannot load {kind}: {type(error).__name__}: {error}") from error
    if found is None or not hasattr(found, "_type") or "action_goal" not in found.__slots__:
        raise GoalError(
            f"there is no action {kind.removesuffix('Action')}; give one of another package as "
            "package/Name. `rosmsg list` lists the types, and those of actions end in Action. The "
            "package must be built, and its setup.bash sourced"
        )
    return found


def read_goal(action_type: type[Message], text: str) -> Any:  # noqa: ANN401 - any ability's goal
    """Return the goal of an action, with id and timeout.

    Args:
        action_type: `...Action` class.
        text: YAML mapping of the goal's fields, or the name of a file that holds one.

    Raises:
        GoalError: if it is not such a mapping, or the action has no id or no timeout.
    """
    is_file = text.endswith((".yaml", ".yml"))
    try:
        fields = yaml.safe_load(Path(text).read_text(encoding="utf-8") if is_file else text)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise GoalError(f"cannot read the goal: {error}") from error
    if not isinstance(fields, dict):
        raise GoalError(f"a goal is a YAML mapping such as '{{cable_id: W1}}', found {text!r}")
    goal = type(action_type().action_goal.goal)()
    lacking = [name for name in ("id", "timeout") if name not in goal.__slots__]
    if lacking:
        raise GoalError(
            f"a goal of {action_type._type} has no {' and no '.join(lacking)}; goals of abilities "
            "have both (Deliverable 5.1, 3.1)"
        )
    try:
        genpy.message.fill_message_args(goal, [{"id": ID, "timeout": TIMEOUT_S, **fields}])
    except (genpy.MessageException, ValueError, TypeError) as error:
        raise GoalError(f"the goal does not fit {action_type._type}: {error}") from error
    return goal
