"""The cell in three dimensions at one moment: robots, wires and components."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from remodel_console.core.cell.robot_model import Quaternion, RobotModel, Vector


@dataclass(frozen=True)
class Robot:
    """A robot, where its root link is in the world, and what precedes its joints' names.

    Attributes:
        description: URDF from which `model` was read.
    """

    model: RobotModel
    prefix: str = ""
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    description: str = field(default="", repr=False)


@dataclass(frozen=True)
class Line:
    """A wire as the points of its middle [m], world frame, with its diameter [m]."""

    points: tuple[Vector, ...]
    diameter: float
    colour: str


@dataclass(frozen=True)
class Solid:
    """A box in the world frame; lengths in [m]."""

    position: Vector
    rotation: Quaternion
    size: Vector
    colour: str


@dataclass(frozen=True)
class CellState:
    """What is to be drawn; two states are compared by the identity of their parts."""

    robots: tuple[Robot, ...] = ()
    joints: Mapping[str, float] = field(default_factory=dict)
    wires: Mapping[str, Line] = field(default_factory=dict)
    boxes: Mapping[str, Solid] = field(default_factory=dict)
