"""The goal of LayWire."""
from __future__ import annotations
from dataclasses import dataclass

@dataclass(frozen=True)
class LayGoal:
    robot_name: str
    guide_name: str
    cable_id: str
