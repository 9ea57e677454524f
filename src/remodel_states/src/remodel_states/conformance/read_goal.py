"""Read the goal that a server is tried with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import genpy
import yaml
from genpy import Message
from roslib.message import get_message_class

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
