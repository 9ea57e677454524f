"""Abilities of the cell: their actions, and the parameters that a goal gives them."""

from __future__ import annotations

from dataclasses import dataclass


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
