"""Panels without labels as they are mounted, under the cameras of their cells.

The panel lies a few millimetres and a degree or so off its place; the devices of a rail stand
further along it, and each a little aside and turned; the light differs from picture to picture.
Some seeds have a mistake: a device is missing, turned by 180 degrees, or another one stands there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

import numpy as np

from remodel_sim.physics.cameras import take
from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.world import World
from remodel_states.edge.wire_material_file import read_wire_materials
from remodel_work.camera import Picture, View, looking_down
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Array, Pose
from remodel_work.panel import BOARD, Component, Panel
from remodel_work.ros.panel_message import read_panel

CONFIG = Path(__file__).parents[2] / "src" / "remodel_sim" / "config"
# The wrist camera's height when it observes a component [m].
LENS_Z = 0.204
# How far the panel lies off its place along x and y [m], and turned [rad].
PANEL_M, PANEL_RAD = 0.008, math.radians(1.5)
LIGHT = (0.4, 1.6)


@dataclass(frozen=True)
class Board:
    """A panel and how its devices are mounted.

    Attributes:
        cell: whose cameras see it.
        panel: its file.
        row: how far the devices of a panel may all stand further along their rails [m].
        along, across: of each device, along its rail and across it [m].
        turn: of each device [rad].
    """

    cell: str
    panel: str
    row: float
    along: float
    across: float
    turn: float


BOARDS = {
    # Devices on rails: 2 mm between neighbours.
    "household": Board("cabinet", "household.yaml", 0.003, 0.0006, 0.0003, math.radians(0.4)),
    # Devices screwed to the plate, each by itself.
    "example": Board("one_panda", "panel.yaml", 0.0, 0.004, 0.003, math.radians(1.5)),
}


class Mistake(Enum):
    """What is not as drawn about one device."""

    MISSING = "missing"
    TURNED = "turned by 180 degrees"
    OTHER = "another device in its place"


class DeviceScene:
    """A panel without labels.

    Attributes:
        panel: as drawn.
        devices: that are to be located: some of the panel's.
        wrong: the device about which something is not as drawn; None: all is.
        poses: where each device stands, by its id, world frame.
    """

    def __init__(
        self, world: World, board: Board, seed: int, count: int, mistake: Mistake | None = None
    ) -> None:
        """Build the scene of a seed in an empty world, with `count` devices to be located."""
        self._random = np.random.default_rng([seed, 11])
        self._world = world
        self.panel = read_panel(CONFIG / board.panel, read_wire_materials())
        cell = read_cell(board.cell)
        self._overhead, self._wrist_lens = cell.overheads[0], cell.robots[0].camera.lens
        dx, dy, turn = self._random.uniform(-1, 1, 3) * (PANEL_M, PANEL_M, PANEL_RAD)
        panel_at = BOARD @ Pose.level(dx, dy, 0.0, turn)
        row = self._random.uniform(-1, 1) * board.row
        self.poses = {}
        for part in self.panel.components:
            along, across, turn = self._random.uniform(-1, 1, 3) * (
                board.along,
                board.across,
                board.turn,
            )
            shifted = Pose.level(across, along + row, 0.0) @ part.panel_from_component
            self.poses[part.id] = panel_at @ shifted @ Pose.level(0.0, 0.0, 0.0, turn)
        chosen = self._random.permutation(len(self.panel.components))[:count]
        self.devices = tuple(self.panel.components[i] for i in chosen)
        self.wrong = self.devices[0] if mistake is not None else None
        stands = self._with(mistake) if mistake is not None else self.panel
        world.clear()
        PanelScene(
            world,
            cell.table,
            replace(stands, wires=()),
            self.poses,
            world_from_panel=panel_at,
            labels=False,
        )

    def _with(self, mistake: Mistake) -> Panel:
        """Return the panel with a mistake about the first of the devices."""
        assert self.wrong is not None, "a mistake is about a device"
        wrong, others = self.wrong, [c for c in self.panel.components if c is not self.wrong]
        if mistake is Mistake.MISSING:
            return replace(self.panel, components=tuple(others))
        if mistake is Mistake.TURNED:
            self.poses[wrong.id] @= Pose.level(0.0, 0.0, 0.0, math.pi)
            return self.panel
        like = [c for c in others if c.size != wrong.size and c.size[1] < wrong.size[1] * 1.1]
        other = like[int(self._random.integers(len(like)))] if like else _wider(wrong)
        standing = replace(other, id=wrong.id, pose=wrong.pose)
        return replace(self.panel, components=(*others, standing))

    def take_overhead_picture(self) -> Picture:
        """Take a picture of the whole plate, with depth."""
        light = self._random.uniform(*LIGHT)
        return take(self._world, self._overhead, self._random, depth=True, light=light)

    def take_wrist_picture(self, place: Array) -> Picture:
        """Take a picture from the hand over a place (2,) [m]; the hand is turned by chance."""
        turn = self._random.uniform(-math.pi, math.pi)
        view = View(self._wrist_lens, looking_down(float(place[0]), float(place[1]), LENS_Z, turn))
        return take(self._world, view, self._random, light=self._random.uniform(*LIGHT))


def _wider(component: Component) -> Component:
    """Return a device like another one, but 4 mm wider and without its last terminal."""
    depth, width, height = component.size
    return replace(
        component, size=(depth, width + 0.004, height), terminals=component.terminals[:-1]
    )
