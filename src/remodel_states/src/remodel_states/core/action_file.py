"""Read action files: the fields of goal and result, with their comments."""

from __future__ import annotations

import re
from dataclasses import dataclass

_FIELD = re.compile(r"^(?P<type>[^\s#]\S*)\s+(?P<name>[a-zA-Z]\w*)\s*(?:#\s*(?P<text>.*))?$")

# Fields that every goal and every result has (Deliverable 5.1, 3.1).
COMMON_GOAL = ("id", "timeout")
COMMON_RESULT = ("id", "success", "message", "elapsed_time", "error_code", "error_message")


@dataclass(frozen=True)
class Field:
    """A field of a message; `type` is that of the ROS message, `text` its comment."""

    name: str
    type: str
    text: str


@dataclass(frozen=True)
class Action:
    """An action.

    Attributes:
        title: what it does: the first comment of its file, without the name.
        goal: fields, those of all goals included.
        result: fields, those of all results included.
    """

    name: str
    title: str
    goal: tuple[Field, ...]
    result: tuple[Field, ...]


def action_from(name: str, text: str) -> Action:
    """Return the action of a file's text."""
    goal, result, *_ = (*text.split("\n---"), "")
    title = next((line.lstrip("# ") for line in goal.splitlines() if line.startswith("#")), "")
    return Action(name, title.removeprefix(f"{name}: "), _fields(goal), _fields(result))


def _fields(text: str) -> tuple[Field, ...]:
    found = filter(None, (_FIELD.match(line.strip()) for line in text.splitlines()))
    return tuple(Field(m["name"], m["type"], (m["text"] or "").strip()) for m in found)
