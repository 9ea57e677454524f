"""The cell in three dimensions, as it is now; written by ROS threads, read by the pages."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field

from remodel_console.core.cell.robot_model import Quaternion, RobotModel, Vector


@dataclass(frozen=True)
class Robot:
    """A robot, where its root link is in the world, and what precedes its joints' names."""

    model: RobotModel
    prefix: str = ""
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)


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


class Scene:
    """Holds the newest state, and knows how many pages show it."""

    def __init__(self) -> None:
        """Begin with an empty cell, and without viewers."""
        self._lock = threading.Lock()
        self._viewers = 0
        self.now = CellState()

    @property
    def is_wanted(self) -> bool:
        """Return whether a page shows it."""
        return self._viewers > 0

    def add_viewer(self, change: int) -> None:
        """Count pages that show it: 1 more, or -1."""
        with self._lock:
            self._viewers += change

    def mesh_file(self, robot: int, mesh: int) -> str | None:
        """Return the file of a mesh, by the numbers that pages know; None if there is none."""
        robots = self.now.robots
        files = robots[robot].model.meshes if 0 <= robot < len(robots) else ()
        return files[mesh] if 0 <= mesh < len(files) else None
