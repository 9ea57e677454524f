"""Abilities of the cell: their actions, and the parameters that a goal gives them."""

from __future__ import annotations

import re
from dataclasses import dataclass

_FIELD = re.compile(r"^(?P<type>\S+)\s+(?P<name>[a-z]\w*)\s*(?:#\s*(?P<text>.*))?$")


@dataclass(frozen=True)
class AbilityParameter:
    """A field of an ability's goal; `type` is that of the ROS message."""

    name: str
    type: str
    description: str


@dataclass(frozen=True)
class Ability:
    """Something that the cell can do; `name` is that of its action."""

    name: str
    description: str
    parameters: tuple[AbilityParameter, ...]


def ability_of(name: str, definition: str) -> Ability:
    """Return the ability that an action file defines: its first comment, and the goal's fields."""
    goal = definition.split("---", 1)[0].splitlines()
    title = next((line.lstrip("# ") for line in goal if line.startswith("#")), "")
    fields = filter(None, (_FIELD.match(line.strip()) for line in goal))
    parameters = tuple(
        AbilityParameter(field["name"], field["type"], (field["text"] or "").strip())
        for field in fields
    )
    return Ability(name, title.removeprefix(f"{name}: "), parameters)
